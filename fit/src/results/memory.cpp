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

const Description& members_of_tests() {
  using M = MemoryFit;
  static const Description all{
      result("leak_z", path(&M::leak, &MemoryTest::z), "No leak, in standard errors"),
      result("leak_p", path(&M::leak, &MemoryTest::p_value), "Its p, two-sided"),
      result("release_z", path(&M::release, &MemoryTest::z),
             "No reservoir at the release, a statement on which nothing in the fit depends"),
      result("release_p", path(&M::release, &MemoryTest::p_value), "Its p, two-sided"),
      result("mechanism_z", path(&M::mechanism, &MemoryTest::z), "The scatter's offset and its width by the same q"),
      result("mechanism_p", path(&M::mechanism, &MemoryTest::p_value), "Its p, two-sided"),
      result("by_speed_z", path(&M::by_speed, &MemoryTest::z),
             "The same q at every speed; above 0: faster impacts want more"),
      result("by_speed_p", path(&M::by_speed, &MemoryTest::p_value), "Its p, two-sided"),
      result<M>(
          "between_drops_ratio",
          [](const M& m) { return m.between_drops ? std::optional(m.between_drops->ratio) : std::nullopt; },
          "Variance between drops of what they ask of the parameters over what their impacts make it, 1 but for "
          "chance; `null` of one drop"),
      result<M>(
          "between_drops_p",
          [](const M& m) { return m.between_drops ? std::optional(m.between_drops->p_value) : std::nullopt; },
          "Its p, one-sided")};
  return all;
}

const Description& members_of_roughness() {
  using M = MemoryFit;
  static const Description all{
      result("q", path(&M::roughness, &Roughness::q, &Estimate::value),
             "c s₂, all that the scatter knows of ball and surface"),
      result("q_se", path(&M::roughness, &Roughness::q, &Estimate::se), "Its standard error"),
      result("q_ci95", path(&M::roughness, &Roughness::q, &Estimate::ci95), "Its 95 % interval"),
      result<M>(
          "ball", [](const M& m) { return text_of_ball(m.ball); },
          "That the following is for; `null` where none was named: a solid sphere"),
      result("inertia_factor", path(&M::roughness, &Roughness::inertia_factor), "Its J/(m R²)"),
      result("s2_no_slip", path(&M::roughness, &Roughness::s2_no_slip),
             "s₂, variance of each component of the contact's offset over R, without slip: q (1 + J/(m R²))"),
      result("s2_frictionless", path(&M::roughness, &Roughness::s2_frictionless),
             "The same without friction: q J/(m R²)"),
      result("rms_tilt_no_slip_deg", path(&M::roughness, &Roughness::rms_tilt_no_slip_deg),
             "Root mean square angle of the contact's normal, √(2 s₂), in degrees"),
      result("n_constant_radii", path(&M::roughness, &Roughness::n_constant_radii),
             "A surface with that `s2_no_slip`: number of asperities of one radius"),
      result("lambda_exponential", path(&M::roughness, &Roughness::lambda_exponential),
             "Another: mean radius over R of exponential ones"),
      result("width_uniform_1e6", path(&M::roughness, &Roughness::width_uniform_1e6),
             "Another: width over R of uniform ones, 1e6 of them"),
      result<M>("leak", leak_of, "As of the memory"),
      result("mechanism_p", path(&M::mechanism, &MemoryTest::p_value), "As of the memory")};
  return all;
}

const Description& members_of(const MemoryFit*) {
  using M = MemoryFit;
  static const Description all{
      result("status", &M::status,
             "`too_few_samples` below 60 impacts or where no drop has 10 successive ones; `not_converged`, also where "
             "the errors could not be found; `ok`"),
      result("message", &M::message, "What speaks against the model, empty where nothing does"),
      result("holds", &M::holds,
             "The model passes its tests (p above .01 for the transforms, `mechanism`, `by_speed` and "
             "`between_drops`) and is likelier than independent impacts. Where not: use `law`"),
      result("n", &M::n, "Impacts used"),
      result("n_drops", &M::n_drops, "Drops they are of"),
      result("n_chains", &M::n_chains, "Pieces of drops without a missing impact"),
      estimates_by_name<M>(),
      result("correlation", &M::correlation, "As of a law"),
      result("covariance", &M::covariance, "As of a law"),
      result("nodes", &M::nodes, "As of a law, at the same nodes"),
      result("node_correlation", &M::node_correlation, "As of a law"),
      where_ok<M>("leak", leak_of,
                  "Estimate of the share of the reservoir that is lost at each impact, long after the release; 0 "
                  "without tangential losses"),
      result("release_m2ps2", &M::release_m2ps2,
             "Estimate of the mean reservoir that the release left, always: that before the first impacts less what "
             "impacts before those add. Below 0 where the first fluctuations are smaller than those of a ball at rest"),
      where_ok<M>("loglik", &M::loglik, "Log-likelihood with memory"),
      result("loglik_independent", &M::loglik_independent, "Of the same impacts as independent ones"),
      result("anderson_darling", &M::anderson_darling,
             "Of the probability transforms of all impacts given the earlier ones: `null`, or `{a2, p_value, "
             "n_replicates}`"),
      result<M>(
          "transform_counts",
          [](const M& m) { return std::vector<double>(m.transform_counts.begin(), m.transform_counts.end()); },
          "Impacts by twentieths of the transform: equal, where the model holds"),
      where_ok<M>("tests", tests_of, "See below; `null` where `status` is not `ok`"),
      result("curve", &M::curve, "As of a law")};
  return all;
}

const Description& members_of(const RoughnessResult*) {
  using R = RoughnessResult;
  static const Description all{
      result("status", path(&R::memory, &MemoryFit::status), "As of the memory"),
      result("message", path(&R::memory, &MemoryFit::message), "As of the memory"),
      result("holds", path(&R::memory, &MemoryFit::holds), "As of the memory"),
      result("n", path(&R::memory, &MemoryFit::n), "Impacts used"),
      result("n_drops", path(&R::memory, &MemoryFit::n_drops), "Drops they are of"),
      result("n_chains", path(&R::memory, &MemoryFit::n_chains), "Pieces of drops without a missing impact"),
      result("n_left_out", &R::n_left_out, "Reason → number of samples left out"),
      result<R>(
          "roughness", [](const R& r) { return where_fitted(r.memory, roughness_of); }, "See [roughness](#roughness)"),
      result<R>(
          "tests", [](const R& r) { return where_fitted(r.memory, tests_of); }, "As of the memory"),
      result("anderson_darling", path(&R::memory, &MemoryFit::anderson_darling), "As of the memory")};
  return all;
}

}  // namespace bouncelab::fit
