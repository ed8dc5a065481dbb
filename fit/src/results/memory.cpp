// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of the fit with memory are called and what they are, key by key (docs/formats.md is made of these
// texts).
#include "bouncelab/fit/memory_fit.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

namespace {

Object tests_of(const MemoryFit& memory) { return object_of(members_of_tests(), &memory); }

Object roughness_of(const MemoryFit& memory) { return object_of(members_of_roughness(), &memory); }

/// `of` where the fit has a result, else not known.
Value where_fitted(const MemoryFit& memory, Object (*of)(const MemoryFit&)) {
  return memory.status == FitStatus::ok ? Value(of(memory)) : Value{};
}

}  // namespace

Value roughness_if_fitted(const MemoryFit& memory) { return where_fitted(memory, roughness_of); }

Description members_of_tests() {
  using M = MemoryFit;
  static constexpr Member all[]{
      member<&M::leak, &MemoryTest::z>("leak_z", "No leak, in standard errors"),
      member<&M::leak, &MemoryTest::p_value>("leak_p", "Its p, two-sided"),
      member<&M::release, &MemoryTest::z>(
          "release_z", "No reservoir at the release, a statement on which nothing in the fit depends"),
      member<&M::release, &MemoryTest::p_value>("release_p", "Its p, two-sided"),
      member<&M::mechanism, &MemoryTest::z>("mechanism_z", "The scatter's offset and its width by the same q"),
      member<&M::mechanism, &MemoryTest::p_value>("mechanism_p", "Its p, two-sided"),
      member<&M::by_speed, &MemoryTest::z>("by_speed_z",
                                           "The same q at every speed; above 0: faster impacts want more"),
      member<&M::by_speed, &MemoryTest::p_value>("by_speed_p", "Its p, two-sided"),
      computed(
          "between_drops_ratio",
          [](const M& m) { return m.between_drops ? std::optional(m.between_drops->ratio) : std::nullopt; },
          "Variance between drops of what they ask of the parameters over what their impacts make it, 1 but for "
          "chance; `null` of one drop"),
      computed(
          "between_drops_p",
          [](const M& m) { return m.between_drops ? std::optional(m.between_drops->p_value) : std::nullopt; },
          "Its p, one-sided")};
  return all;
}

Description members_of_roughness() {
  using M = MemoryFit;
  static constexpr Member all[]{
      member<&M::roughness, &Roughness::q, &Estimate::value>("q",
                                                             "c s₂, all that the scatter knows of ball and surface"),
      member<&M::roughness, &Roughness::q, &Estimate::se>("q_se", "Its standard error"),
      member<&M::roughness, &Roughness::q, &Estimate::ci95>("q_ci95", "Its 95 % interval"),
      computed(
          "ball", [](const M& m) { return m.ball ? std::optional(to_text(*m.ball)) : std::nullopt; },
          "That the following is for; `null` where none was named: a solid sphere"),
      member<&M::roughness, &Roughness::inertia_factor>("inertia_factor", "Its J/(m R²)"),
      member<&M::roughness, &Roughness::s2_no_slip>(
          "s2_no_slip",
          "s₂, variance of each component of the contact's offset over R, without slip: q (1 + J/(m R²))"),
      member<&M::roughness, &Roughness::s2_frictionless>("s2_frictionless", "The same without friction: q J/(m R²)"),
      member<&M::roughness, &Roughness::rms_tilt_no_slip_deg>(
          "rms_tilt_no_slip_deg", "Root mean square angle of the contact's normal, √(2 s₂), in degrees"),
      member<&M::roughness, &Roughness::n_constant_radii>(
          "n_constant_radii", "A surface with that `s2_no_slip`: number of asperities of one radius"),
      member<&M::roughness, &Roughness::lambda_exponential>("lambda_exponential",
                                                            "Another: mean radius over R of exponential ones"),
      member<&M::roughness, &Roughness::width_uniform_1e6>("width_uniform_1e6",
                                                           "Another: width over R of uniform ones, 1e6 of them"),
      member<leak_of>("leak", "As of the memory"),
      member<&M::mechanism, &MemoryTest::p_value>("mechanism_p", "As of the memory")};
  return all;
}

Description members_of(const MemoryFit*) {
  using M = MemoryFit;
  static constexpr Member all[]{
      member<&M::status>(
          "status",
          "`too_few_samples` below 60 impacts or where no drop has 10 successive ones; `not_converged`, also where "
          "the errors could not be found; `ok`"),
      member<&M::holds>("holds",
                        "The model passes its tests (p above .01 for the transforms, `mechanism`, `by_speed` and "
                        "`between_drops`) and is likelier than independent impacts. Else `constants` are of impacts "
                        "taken as independent"),
      member<&M::n>("n", "Impacts used"),
      member<&M::n_drops>("n_drops", "Drops they are of"),
      member<&M::n_chains>("n_chains", "Pieces of drops without a missing impact"),
      where_ok<leak_of>("leak",
                        "Estimate of the share of the reservoir that is lost at each impact, long after the release; 0 "
                        "without tangential losses"),
      member<&M::release_m2ps2>(
          "release_m2ps2",
          "Estimate of the mean reservoir that the release left, always: that before the first impacts less what "
          "impacts before those add. Below 0 where the first fluctuations are smaller than those of a ball at rest"),
      where_ok<&M::loglik>("loglik", "Log-likelihood with memory"),
      member<&M::loglik_independent>("loglik_independent", "Of the same impacts as independent ones"),
      member<&M::anderson_darling>(
          "anderson_darling",
          "Of the probability transforms of all impacts given the earlier ones: `null`, or `{a2, p_value, "
          "n_replicates}`"),
      computed(
          "transform_counts",
          [](const M& m) { return std::vector<double>(m.transform_counts.begin(), m.transform_counts.end()); },
          "Impacts by twentieths of the transform: equal, where the model holds"),
      where_ok<tests_of>("tests", "See below; `null` where `status` is not `ok`")};
  return all;
}

Description members_of(const RoughnessResult*) {
  using R = RoughnessResult;
  static constexpr Member all[]{
      member<&R::memory, &MemoryFit::status>("status", "As of the memory"),
      member<&R::memory, &MemoryFit::holds>("holds", "As of the memory"),
      member<&R::memory, &MemoryFit::n>("n", "Impacts used"),
      member<&R::memory, &MemoryFit::n_drops>("n_drops", "Drops they are of"),
      member<&R::memory, &MemoryFit::n_chains>("n_chains", "Pieces of drops without a missing impact"),
      member<&R::n_left_out>("n_left_out", "Reason → number of samples left out"),
      computed(
          "roughness", [](const R& r) { return where_fitted(r.memory, roughness_of); }, "See [roughness](#roughness)"),
      computed(
          "tests", [](const R& r) { return where_fitted(r.memory, tests_of); }, "As of the memory"),
      member<&R::memory, &MemoryFit::anderson_darling>("anderson_darling", "As of the memory")};
  return all;
}

}  // namespace bouncelab::fit
