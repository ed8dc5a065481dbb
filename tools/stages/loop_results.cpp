// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/loop_results.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/report/notes.hpp"

namespace bouncelab::stages {
namespace {

std::string cell(const std::optional<fit::Estimate>& estimate) {
  return estimate ? fit::in_words(estimate->value, estimate->se) : "-";
}

/// Pads to a width counted in characters, not bytes ("±" has two).
std::string padded(const std::string& text, std::size_t width) {
  const auto n = static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  return n < width ? std::string(width - n, ' ') + text : text;
}

std::string row(const std::string& head, const std::vector<std::string>& cells) {
  std::string line = fmt::format("  {:<24}", head);
  for (const std::string& cell : cells) line += padded(cell, 24);
  return line + "\n";
}

std::string row(const std::string& head, const std::string& truth, const loop::Compared& compared) {
  return row(head, {truth, cell(compared.from_true_times), cell(compared.from_sound)});
}

std::string onsets_text(const detection::OnsetScore& s) {
  std::string text = fmt::format("Impacts: {} simulated, {} found, {} missed, {} invented\n", s.n_true, s.n_found,
                                 s.n_missed, s.n_invented);
  if (s.rms_s)
    text += fmt::format("Error of t_i: {:.3g} us rms about a constant {:.3g} us; within drops {:.3g} us\n",
                        1e6 * *s.rms_s, 1e6 * s.offset_s.value_or(0.0), 1e6 * s.rms_within_drops_s.value_or(0.0));
  if (s.pull_sd)
    text += fmt::format(
        "Error within drops, less the residual of the contact-time law, over the standard error stated: {:.3g} rms\n",
        *s.pull_sd);
  return text;
}

std::string slope_cell(const fit::Estimate& e) {
  return fmt::format("{:>7.0f} ± {:<4.0f}", e.value, e.se.value_or(0.0));
}

std::string pair_text(const loop::SlopePair& pair) {
  return fmt::format("{} {}  {:>6.3f}", slope_cell(pair.simulation), slope_cell(pair.sound), pair.ratio);
}

std::string reservoir_text(const loop::ReservoirCheck& r) {
  std::string text = fmt::format(
      "\nEnergy in spin and sideways motion (twice, per mass; {:.0f}% of it spin) of {} drops, from sound against "
      "simulated:\n"
      "  correlation {:.6f}, rms difference {:.2g} of {:.2g} m2/s2; expected from timing and contact's offset {:.1g}",
      100.0 * r.spin_share, r.drops.size(), r.correlation, r.rms_difference_m2ps2, r.rms_simulated_m2ps2,
      hypot(r.expected_timing_m2ps2, r.expected_offset_m2ps2));
  if (r.expected_law_m2ps2)
    text += fmt::format(", from the law {} {:.2g}", r.with_memory ? "fitted with memory" : "of independent impacts",
                        *r.expected_law_m2ps2);
  return text + "\n";
}

/// A value of a sweep's point, formatted; "-" where it is not known.
std::string cell(const loop::SweepPoint& point, const std::string& name, const char* format, double scale = 1.0) {
  for (const loop::SweepValue& v : point.values)
    if (v.name == name && v.value) return fmt::format(fmt::runtime(format), scale * *v.value);
  return "-";
}

/// Spread of eps against speed, as the budget has it.
Object spread_of(const fit::FitResult& fit) {
  std::vector<double> v_mps, spread;
  for (const fit::BudgetRow& row : fit.budget.rows) {
    v_mps.push_back(row.v_mps);
    spread.push_back(row.spread);
  }
  Value exponent;
  if (const std::optional<fit::Estimate>& k = fit.budget.width_exponent) {
    Object known{{"value", k->value}};
    if (k->se) known.emplace_back("se", *k->se);
    if (k->ci95) known.emplace_back("ci95", value_of(*k->ci95));
    exponent = std::move(known);
  }
  return {{"v_mps", v_mps}, {"spread", spread}, {"exponent", exponent}};
}

}  // namespace

Object loop_summary(const loop::LoopScore& score, const loop::LoopResult& loop, const std::vector<Note>& notes,
                    const std::optional<LoopWork>& work) {
  Object summary = object_of(score);
  if (loop.theory) summary.emplace_back("theory", value_of(*loop.theory));
  if (loop.reservoir) summary.emplace_back("reservoir", value_of(*loop.reservoir));
  if (loop.section.n_asperities > 0) summary.emplace_back("ball", value_of(loop.section));
  summary.emplace_back("notes", report::values_of(notes));
  if (work) {
    summary.emplace_back("seconds", value_of(loop.clock.wall_s()));
    summary.emplace_back("sound_s", work->sound_s);
    summary.emplace_back("processor_seconds", value_of(loop.clock.processor_s()));
    summary.emplace_back("peak_memory_bytes", work->peak_memory_bytes);
  }
  return summary;
}

Object paper_results(const loop::LoopResult& loop, const std::vector<loop::SlopeWindow>& slopes,
                     const std::vector<report::Conclusion>& conclusions) {
  return {{"conclusions", value_of(conclusions)},
          {"slopes", value_of(slopes)},
          {"spread", Object{{"simulation", spread_of(loop.direct)},
                            {"sound", spread_of(loop.sound)},
                            {"smooth_ball", spread_of(loop.smooth_sound)}}},
          {"smooth_ball", Object{{"n_drops", value_of(loop.smooth.recordings.size())},
                                 {"n_impacts", value_of(loop.smooth.score.n_true)},
                                 {"n_missed", value_of(loop.smooth.score.n_missed)},
                                 {"n_invented", value_of(loop.smooth.score.n_invented)}}},
          {"energy_shares", as_lists(loop.shares)}};
}

std::string loop_text(const loop::LoopScore& score, const loop::LoopResult& loop) {
  std::string text = onsets_text(score.onsets);
  text += "\n" + row("", {"truth", "from true times", "from sound"});
  for (const loop::ComparedNode& n : score.nodes)
    text += row(fmt::format("eps at {:g} m/s", n.v_mps), fmt::format("{:.6f}", n.truth), n.eps);
  for (const loop::ComparedNode& n : score.nodes)
    if (n.eps_with_memory.from_sound || n.eps_with_memory.from_true_times)
      text += row(fmt::format("with memory at {:g} m/s", n.v_mps), fmt::format("{:.6f}", n.truth), n.eps_with_memory);
  for (const loop::ComparedConstant& c : score.constants)
    text += row(c.name, c.truth ? fmt::format("{:g}", *c.truth) : "-", c.value);
  for (const loop::ComparedSlopes& s : score.slopes) {
    text += row(fmt::format("rising slope at {:g} m/s", s.v_mps), "", s.rising);
    text += row(fmt::format("falling slope at {:g} m/s", s.v_mps), "", s.falling);
  }
  if (loop.reservoir) text += reservoir_text(*loop.reservoir);
  text += "\nSeconds:";
  for (const auto& [stage, s] : loop.clock.wall_s()) text += fmt::format(" {} {:.1f}", stage, s);
  return text + "\n";
}

std::string paper_text(const std::vector<loop::SlopeWindow>& slopes,
                       const std::vector<report::Conclusion>& conclusions) {
  std::string text =
      "\nSlopes of p(eps)              rising                                falling\n"
      "  window     simulation       sound        ratio    simulation       sound        ratio\n";
  for (const loop::SlopeWindow& w : slopes)
    text += fmt::format("  {:.1f} m/s {}  {}\n", w.v_mps, pair_text(w.rising), pair_text(w.falling));
  text += "\nWhat the paper concludes\n";
  for (const report::Conclusion& c : conclusions) {
    text += fmt::format("  {:<14} {}: ", c.holds ? "holds" : "DOES NOT HOLD", c.claim);
    text += c.value ? fmt::format("{:.4g}", *c.value) : "not known";
    if (c.ci95) text += fmt::format(" [{:.4g}, {:.4g}]", c.ci95->lo, c.ci95->hi);
    text += fmt::format(" ({}; {})\n", c.measure, c.detail);
  }
  return text;
}

std::string work_text(const LoopWork& work, const SecondsByStage& processor_s, std::size_t n_impacts) {
  const double hours = work.sound_s / 3600.0;
  std::string text = fmt::format("\n{:.2f} h of sound; peak memory {:.0f} MB\nProcessor time by stage\n", hours,
                                 work.peak_memory_bytes / 1e6);
  for (const auto& [stage, s] : processor_s)
    text += fmt::format("  {:<22}{:8.2f} s {:8.3f} s per hour of sound {:8.2f} us per impact\n", stage, s, s / hours,
                        1e6 * s / static_cast<double>(n_impacts));
  return text;
}

std::string sweep_text(const std::vector<loop::SweepPoint>& points) {
  std::size_t width = 8;
  for (const loop::SweepPoint& point : points) width = std::max(width, loop::text_of(point.settings).size());
  std::string text = fmt::format("{:<{}} {:>7} {:>9} {:>9} {:>15} {:>15}  {}\n", "settings", width, "recall",
                                 "precision", "rms us", "rising .6 m/s", "falling .6 m/s", "failure");
  for (const loop::SweepPoint& point : points)
    text += fmt::format(
        "{:<{}} {:>7} {:>9} {:>9} {:>15} {:>15}  {}\n", loop::text_of(point.settings), width,
        cell(point, "recall", "{:.4f}"), cell(point, "precision", "{:.4f}"),
        cell(point, "time_rms_within_drops_s", "{:.2f}", 1e6),
        cell(point, "slope_rising_0.6_sound", "{:.0f}") + " ± " + cell(point, "se_slope_rising_0.6_sound", "{:.0f}"),
        cell(point, "slope_falling_0.6_sound", "{:.0f}") + " ± " + cell(point, "se_slope_falling_0.6_sound", "{:.0f}"),
        point.failure);
  return text;
}

}  // namespace bouncelab::stages
