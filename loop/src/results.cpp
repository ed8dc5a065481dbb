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

/// A member of one side of what is compared.
template <auto What, auto Side>
constexpr Member compared(std::string_view name, const char* text) {
  using S = decltype(describe_detail::owner_of(What));
  constexpr bool is_eps = std::is_same_v<S, ComparedNode>;
  return computed(
      name, [](const S& s) { return value_and_error(s.*What.*Side, is_eps ? "eps" : "value"); }, text);
}

/// The same by the fits with memory, left out where neither side is known.
template <auto Side>
constexpr Member with_memory(std::string_view name) {
  return computed(
             name,
             [](const ComparedNode& node) {
               const Compared& both = node.eps_with_memory;
               return both.from_sound || both.from_true_times ? Value(value_and_error(both.*Side, "eps")) : Value{};
             },
             "The same by the fits with memory")
      .left_out_where_unknown();
}

Object both_slopes(const ComparedSlopes& s, std::optional<fit::Estimate> Compared::*side) {
  return {{"rising", value_and_error(s.rising.*side, "value")}, {"falling", value_and_error(s.falling.*side, "value")}};
}

}  // namespace

Description members_of(const ComparedNode*) {
  using N = ComparedNode;
  static constexpr Member all[]{member<&N::v_mps>("v_mps", "Speed"),
                                member<&N::truth>("truth", "ε of the law simulated"),
                                compared<&N::eps, &Compared::from_true_times>("from_true_times", "`{eps, se}`"),
                                compared<&N::eps, &Compared::from_sound>("from_sound", "`{eps, se}`"),
                                with_memory<&Compared::from_true_times>("from_true_times_with_memory"),
                                with_memory<&Compared::from_sound>("from_sound_with_memory")};
  return all;
}

Description members_of(const ComparedConstant*) {
  using C = ComparedConstant;
  static constexpr Member all[]{member<&C::name>("name", "`A2`, `A4`, `A5`"),
                                compared<&C::value, &Compared::from_true_times>("from_true_times", "`{value, se}`"),
                                compared<&C::value, &Compared::from_sound>("from_sound", "`{value, se}`"),
                                member<&C::truth>("truth", "Of the law simulated").left_out_where_unknown()};
  return all;
}

Description members_of(const ComparedSlopes*) {
  using S = ComparedSlopes;
  static constexpr Member all[]{
      member<&S::v_mps>("v_mps", "Centre of the window"),
      computed(
          "from_true_times", [](const S& s) { return both_slopes(s, &Compared::from_true_times); },
          "`{rising, falling}`, each `{value, se}`"),
      computed(
          "from_sound", [](const S& s) { return both_slopes(s, &Compared::from_sound); }, "Likewise")};
  return all;
}

Description members_of(const LawPoint*) {
  static constexpr Member all[]{member<&LawPoint::v_mps>("v_mps", "Speed"), member<&LawPoint::eps>("eps", "ε")};
  return all;
}

Description members_of(const LoopScore*) {
  using S = LoopScore;
  static constexpr Member all[]{
      member<&S::n_drops>("n_drops", "Drops"),
      member<&S::onsets>("score",
                         "[Scores](validation.md#the-scores) of detected against true times: `n_true`, `n_found`, ..."),
      member<&S::n_samples>("n_samples", "Samples fitted"),
      member<&S::nodes>("eps_nodes", "`[{v_mps, truth, from_true_times: {eps, se}, from_sound: {eps, se}}]`"),
      member<&S::constants>("constants", "`[{name, truth, from_true_times: {value, se}, from_sound: {value, se}}]`"),
      member<&S::slopes>(
          "slopes",
          "`[{v_mps, from_true_times: {rising, falling}, from_sound: {rising, falling}}]`, each `{value, se}`"),
      member<&S::truth_curve>("truth_curve", "`[{v_mps, eps}]` of the law that went in")};
  return all;
}

Value as_value(const SlopePair& pair) {
  return Object{{"simulation", value_of(pair.simulation)},
                {"sound", value_of(pair.sound)},
                {"ratio", pair.sound.value / pair.simulation.value}};
}

Description members_of(const SlopeWindow*) {
  using W = SlopeWindow;
  static constexpr Member all[]{
      member<&W::v_mps>("v_mps", "Centre of the window"), member<&W::n_simulation>("n_simulation", "Samples"),
      member<&W::n_sound>("n_sound", "Samples"),
      member<&W::rising>("rising", "`{simulation, sound, ratio}` with estimates `{value, se, ci95}`"),
      member<&W::falling>("falling", "Likewise")};
  return all;
}

Description members_of(const ExpectedSlopes*) {
  using S = ExpectedSlopes;
  static constexpr Member all[]{
      member<&S::v_mps>("v_mps", "Centre of the window"), member<&S::n>("n", "Simulated impacts in it"),
      member<&S::rising>("rising", "Slope below ε(v)"), member<&S::falling>("falling", "Slope above it")};
  return all;
}

Description members_of(const ExpectedDensity*) {
  using D = ExpectedDensity;
  static constexpr Member all[]{
      member<&D::v_mps>("v_mps", "Centre of the window"), member<&D::eps>("eps", "Where"),
      member<&D::density>("density", "p(ε) without timing noise"),
      member<&D::n_simulated>("n_simulated", "Impacts in the window"),
      member<&D::simulated_counts>("simulated_counts", "In the bins of fit.json's histogram, moved to the centre")};
  return all;
}

Description members_of(const ScatterTheory*) {
  using T = ScatterTheory;
  static constexpr Member all[]{
      member<&T::q>("q", "c s₂"),
      member<&T::contact_factor>("contact_factor", "c"),
      member<&T::offset_variance>("offset_variance", "s₂"),
      member<&T::slopes>("slopes", "`[{v_mps, n, rising, falling}]` over the n simulated impacts of each window"),
      member<&T::densities>("densities", "`[{v_mps, eps, density, n_simulated, simulated_counts}]`"),
      member<&T::n_transforms>("n_transforms", "Probability transforms of the simulated impacts"),
      member<&T::transform_counts>("transform_counts", "By twentieths")};
  return all;
}

Description members_of(const ReservoirOfDrop*) {
  using D = ReservoirOfDrop;
  static constexpr Member all[]{
      member<&D::drop>("drop", "Number of the drop"),
      member<&D::first_impact>("first_impact", "Of the longest stretch without a missing impact"),
      member<&D::last_impact>("last_impact", "Likewise"),
      member<&D::simulated_m2ps2>("simulated_m2ps2", "As simulated"),
      member<&D::sound, &fit::ReservoirGain::gain_m2ps2>("sound_m2ps2", "From the sound"),
      computed(
          "own_se_m2ps2", [](const D& d) { return hypot(d.sound.timing_se_m2ps2, d.sound.offset_se_m2ps2); },
          "Timing and offset"),
      member<&D::sound, &fit::ReservoirGain::law_se_m2ps2>("law_se_m2ps2", "The law, common to all drops")};
  return all;
}

Description members_of(const ReservoirCheck*) {
  using C = ReservoirCheck;
  static constexpr Member all[]{
      computed(
          "law", [](const C& c) { return c.with_memory ? "memory" : "independent"; },
          "The fit to the sound whose ε(v) is taken"),
      computed(
          "n_drops", [](const C& c) { return c.drops.size(); }, "Drops"),
      member<&C::correlation>("correlation", "Over the drops, of sound and simulation"),
      member<&C::rms_simulated_m2ps2>("rms_simulated_m2ps2", "Simulated"),
      member<&C::mean_difference_m2ps2>("mean_difference_m2ps2", "Sound less simulated"),
      member<&C::rms_difference_m2ps2>("rms_difference_m2ps2", "Likewise"),
      member<&C::expected_law_m2ps2>("expected_law_m2ps2", "Rms error expected, common to all drops"),
      member<&C::expected_timing_m2ps2>("expected_timing_m2ps2", "Likewise, of the times"),
      member<&C::expected_offset_m2ps2>("expected_offset_m2ps2",
                                        "Likewise, of the contacts, of which only the variance is known"),
      member<&C::spin_share>("spin_share", "Of the simulated reservoir"),
      computed(
          "drops", [](const C& c) { return as_lists(c.drops); }, "Each a list")};
  return all;
}

Description members_of(const SweepPoint*) {
  using P = SweepPoint;
  static constexpr Member all[]{
      member<&P::settings>("settings", "Option → value"),
      computed(
          "values",
          [](const P& p) {
            Object values;
            for (const SweepValue& v : p.values)
              values.emplace_back(
                  v.name, v.is_count && v.value ? value_of(static_cast<std::uint64_t>(*v.value)) : value_of(v.value));
            return values;
          },
          "The columns of sweep.csv"),
      member<&P::failure>("trouble", "The first thing that does not work at this point; empty where all does")};
  return all;
}

}  // namespace bouncelab::loop
