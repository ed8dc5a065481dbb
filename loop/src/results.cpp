// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of closed loops are called and what they are, key by key (docs/formats.md is made of these texts).
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/loop/loop.hpp"

namespace bouncelab::loop {
namespace {

/// {value, se} as far as they are known.
Object value_and_error(const std::optional<fit::Estimate>& estimate, const char* value_name) {
  Object all;
  if (!estimate) return all;
  if (std::isfinite(estimate->value)) all.emplace_back(value_name, estimate->value);
  if (estimate->se && std::isfinite(*estimate->se)) all.emplace_back("se", *estimate->se);
  return all;
}

/// A member that has it of one side of what is compared.
template <class S>
Member compared(std::string name, Compared S::*what, std::optional<fit::Estimate> Compared::*side,
                const char* value_name, std::string text) {
  return result<S>(
      std::move(name), [=](const S& s) { return value_and_error(s.*what.*side, value_name); }, std::move(text));
}

/// The same, left out where neither side is known.
Member with_memory(std::string name, std::optional<fit::Estimate> Compared::*side) {
  return result<ComparedNode>(
             std::move(name),
             [side](const ComparedNode& node) {
               const Compared& both = node.eps_with_memory;
               return both.from_sound || both.from_true_times ? Value(value_and_error(both.*side, "eps")) : Value{};
             },
             "The same by the fits with memory")
      .left_out_where_unknown();
}

Object both_slopes(const ComparedSlopes& s, std::optional<fit::Estimate> Compared::*side) {
  return {{"rising", value_and_error(s.rising.*side, "value")}, {"falling", value_and_error(s.falling.*side, "value")}};
}

Object estimate_of(const fit::Estimate& estimate) {
  Object all{{"value", estimate.value}};
  if (estimate.se) all.emplace_back("se", *estimate.se);
  if (estimate.ci95) all.emplace_back("ci95", value_of(*estimate.ci95));
  return all;
}

}  // namespace

const Description& members_of(const ComparedNode*) {
  using N = ComparedNode;
  static const Description all{result("v_mps", &N::v_mps, "Speed"),
                               result("truth", &N::truth, "ε of the law simulated"),
                               compared("from_true_times", &N::eps, &Compared::from_true_times, "eps", "`{eps, se}`"),
                               compared("from_sound", &N::eps, &Compared::from_sound, "eps", "`{eps, se}`"),
                               with_memory("from_true_times_with_memory", &Compared::from_true_times),
                               with_memory("from_sound_with_memory", &Compared::from_sound)};
  return all;
}

const Description& members_of(const ComparedConstant*) {
  using C = ComparedConstant;
  static const Description all{
      result("name", &C::name, "`A2`, `A4`, `A5`"),
      compared("from_true_times", &C::value, &Compared::from_true_times, "value", "`{value, se}`"),
      compared("from_sound", &C::value, &Compared::from_sound, "value", "`{value, se}`"),
      result("truth", &C::truth, "Of the law simulated").left_out_where_unknown()};
  return all;
}

const Description& members_of(const ComparedSlopes*) {
  using S = ComparedSlopes;
  static const Description all{
      result("v_mps", &S::v_mps, "Centre of the window"),
      result<S>(
          "from_true_times", [](const S& s) { return both_slopes(s, &Compared::from_true_times); },
          "`{rising, falling}`, each `{value, se}`"),
      result<S>(
          "from_sound", [](const S& s) { return both_slopes(s, &Compared::from_sound); }, "Likewise")};
  return all;
}

const Description& members_of(const LawPoint*) {
  static const Description all{result("v_mps", &LawPoint::v_mps, "Speed"), result("eps", &LawPoint::eps, "ε")};
  return all;
}

const Description& members_of(const LoopScore*) {
  using S = LoopScore;
  static const Description all{
      result("n_drops", &S::n_drops, "Drops"),
      result<S>(
          "", [](const S& s) { return std::get<Object>(value_of(s.onsets)); }, "Detected against true impacts"),
      result("n_samples", &S::n_samples, "Samples fitted"),
      result("eps_nodes", &S::nodes, "`[{v_mps, truth, from_true_times: {eps, se}, from_sound: {eps, se}}]`"),
      result("constants", &S::constants, "`[{name, truth, from_true_times: {value, se}, from_sound: {value, se}}]`"),
      result("slopes", &S::slopes,
             "`[{v_mps, from_true_times: {rising, falling}, from_sound: {rising, falling}}]`, each `{value, se}`"),
      result("truth_curve", &S::truth_curve, "`[{v_mps, eps}]` of the law that went in")};
  return all;
}

Value as_value(const SlopePair& pair) {
  return Object{
      {"simulation", estimate_of(pair.simulation)}, {"sound", estimate_of(pair.sound)}, {"ratio", pair.ratio}};
}

const Description& members_of(const SlopeWindow*) {
  using W = SlopeWindow;
  static const Description all{
      result("v_mps", &W::v_mps, "Centre of the window"), result("n_simulation", &W::n_simulation, "Samples"),
      result("n_sound", &W::n_sound, "Samples"),
      result("rising", &W::rising, "`{simulation, sound, ratio}` with estimates `{value, se, ci95}`"),
      result("falling", &W::falling, "Likewise")};
  return all;
}

const Description& members_of(const ExpectedSlopes*) {
  using S = ExpectedSlopes;
  static const Description all{
      result("v_mps", &S::v_mps, "Centre of the window"), result("n", &S::n, "Simulated impacts in it"),
      result("rising", &S::rising, "Slope below ε(v)"), result("falling", &S::falling, "Slope above it")};
  return all;
}

const Description& members_of(const ExpectedDensity*) {
  using D = ExpectedDensity;
  static const Description all{
      result("v_mps", &D::v_mps, "Centre of the window"), result("eps", &D::eps, "Where"),
      result("density", &D::density, "p(ε) without timing noise"),
      result("n_simulated", &D::n_simulated, "Impacts in the window"),
      result("simulated_counts", &D::simulated_counts, "In the bins of fit.json's histogram, moved to the centre")};
  return all;
}

const Description& members_of(const ScatterTheory*) {
  using T = ScatterTheory;
  static const Description all{
      result("q", &T::q, "c s₂"),
      result("contact_factor", &T::contact_factor, "c"),
      result("offset_variance", &T::offset_variance, "s₂"),
      result("slopes", &T::slopes, "`[{v_mps, n, rising, falling}]` over the n simulated impacts of each window"),
      result("densities", &T::densities, "`[{v_mps, eps, density, n_simulated, simulated_counts}]`"),
      result("n_transforms", &T::n_transforms, "Probability transforms of the simulated impacts"),
      result<T>(
          "transform_counts",
          [](const T& t) { return std::vector<std::size_t>(t.transform_counts.begin(), t.transform_counts.end()); },
          "By twentieths")};
  return all;
}

const Description& members_of(const ReservoirOfDrop*) {
  using D = ReservoirOfDrop;
  static const Description all{
      result("drop", &D::drop, "Number of the drop"),
      result("first_impact", &D::first_impact, "Of the longest stretch without a missing impact"),
      result("last_impact", &D::last_impact, "Likewise"),
      result("simulated_m2ps2", &D::simulated_m2ps2, "As simulated"),
      result("sound_m2ps2", path(&D::sound, &fit::ReservoirGain::gain_m2ps2), "From the sound"),
      result<D>(
          "own_se_m2ps2", [](const D& d) { return hypot(d.sound.timing_se_m2ps2, d.sound.offset_se_m2ps2); },
          "Timing and offset"),
      result("law_se_m2ps2", path(&D::sound, &fit::ReservoirGain::law_se_m2ps2), "The law, common to all drops")};
  return all;
}

const Description& members_of(const ReservoirCheck*) {
  using C = ReservoirCheck;
  static const Description all{
      result<C>(
          "law", [](const C& c) { return c.with_memory ? "memory" : "independent"; },
          "The fit to the sound whose ε(v) is taken"),
      result<C>(
          "n_drops", [](const C& c) { return c.drops.size(); }, "Drops"),
      result("correlation", &C::correlation, "Over the drops, of sound and simulation"),
      result("rms_simulated_m2ps2", &C::rms_simulated_m2ps2, "Simulated"),
      result("mean_difference_m2ps2", &C::mean_difference_m2ps2, "Sound less simulated"),
      result("rms_difference_m2ps2", &C::rms_difference_m2ps2, "Likewise"),
      result("expected_law_m2ps2", &C::expected_law_m2ps2, "Rms error expected, common to all drops"),
      result("expected_timing_m2ps2", &C::expected_timing_m2ps2, "Likewise, of the times"),
      result("expected_offset_m2ps2", &C::expected_offset_m2ps2,
             "Likewise, of the contacts, of which only the variance is known"),
      result("spin_share", &C::spin_share, "Of the simulated reservoir"),
      result<C>(
          "drops", [](const C& c) { return as_lists(c.drops); }, "Each a list")};
  return all;
}

const Description& members_of(const SweepPoint*) {
  using P = SweepPoint;
  static const Description all{
      result("settings", &P::settings, "Option → value"),
      result<P>(
          "values",
          [](const P& p) {
            Object values;
            for (const SweepValue& v : p.values)
              values.emplace_back(
                  v.name, v.is_count && v.value ? value_of(static_cast<std::uint64_t>(*v.value)) : value_of(v.value));
            return values;
          },
          "The columns of sweep.csv"),
      result("trouble", &P::failure, "The first thing that does not work at this point; empty where all does")};
  return all;
}

const Description& members_of(const MemoryCalibrationRow*) {
  using R = MemoryCalibrationRow;
  static const Description all{
      result("quantity", &R::quantity, "`eps_025`, `A2`, `q` ..."),
      result("n", &R::n, "Fits"),
      result("pull_mean", &R::pull_mean, "Mean of (estimate - truth) / se").left_out_where_unknown(),
      result("pull_sd", &R::pull_sd, "Its standard deviation").left_out_where_unknown(),
      result("coverage68", &R::coverage68, "Share of the 68 % intervals that hold the truth").left_out_where_unknown(),
      result("coverage95", &R::coverage95, "Of the 95 % intervals").left_out_where_unknown(),
      result("rms_error", &R::rms_error, "Of the fit with memory").left_out_where_unknown(),
      result("rms_error_independent", &R::rms_error_independent, "Of that to independent impacts")
          .left_out_where_unknown(),
      result("gain", &R::gain, "Mean square error of the latter over that of the former").left_out_where_unknown()};
  return all;
}

const Description& members_of(const MemoryCalibrationGroup*) {
  using G = MemoryCalibrationGroup;
  static const Description all{result("family", &G::family, "What they have in common: `radii`, `release` ..."),
                               result("name", &G::name, "Its value"),
                               result("n", &G::n, "Experiments"),
                               result("n_failed", &G::n_failed, "Without a fit"),
                               result("n_holds", &G::n_holds, "Whose test of the model passes"),
                               result("rows", &G::rows, "A row for each quantity")};
  return all;
}

}  // namespace bouncelab::loop
