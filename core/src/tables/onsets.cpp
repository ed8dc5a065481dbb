// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/onsets.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {

namespace {

constexpr std::string_view kFlagNames[]{"by_hand",  "clipped",        "doubtful",   "extra_impact", "improbable",
                                        "inferred", "missing_impact", "not_finite", "overlap"};

}  // namespace

std::string_view name_of(Flag flag) { return kFlagNames[static_cast<std::size_t>(flag)]; }

std::optional<Flag> flag_named(std::string_view word) {
  const auto* const found = std::find(std::begin(kFlagNames), std::end(kFlagNames), word);
  return found == std::end(kFlagNames) ? std::nullopt : std::optional(static_cast<Flag>(found - kFlagNames));
}

Flags::Flags(std::initializer_list<Flag> flags) {
  for (const Flag flag : flags) add(flag);
}

Flags Flags::from_text(std::string text) {
  Flags flags;
  if (text.find_first_not_of(" \t") != std::string::npos) flags.text_ = std::move(text);
  return flags;
}

bool Flags::has(Flag flag) const {
  const std::string_view name = name_of(flag);
  std::string_view rest = text_;
  while (!rest.empty()) {
    const auto bar = rest.find('|');
    if (rest.substr(0, bar) == name) return true;
    if (bar == std::string_view::npos) return false;
    rest.remove_prefix(bar + 1);
  }
  return false;
}

std::string_view Flags::first_word() const { return std::string_view(text_).substr(0, text_.find('|')); }

void Flags::add(Flag flag) {
  if (has(flag)) return;
  if (!text_.empty()) text_ += '|';
  text_ += name_of(flag);
}

std::string recording_cell(const std::string& recording) {
  const std::string_view formula = "=+-@\t\r\n";
  return !recording.empty() && formula.find(recording.front()) != std::string_view::npos ? "./" + recording : recording;
}

const RowColumns<Onset>& columns_of(const Onset*) {
  using O = Onset;
  static const RowColumns<O> all{
      recording_column<O>(),
      column("drop", &O::drop, "Drop within the recording", kIndexRange),
      column("impact", &O::impact, "Impact within the drop (jumps where an impact was not found)", kIndexRange),
      column("t_s", &O::t_s,
             "Start of contact plus the travel time of the sound, from the first sample of the recording, sub-sample",
             known(kTimeRange_s))
          .required(),
      column("sigma_t_s", &O::sigma_t_s,
             "Standard error of `t_s` against the other times of its drop; independent from impact to impact. What all "
             "times of a drop share, a constant and the error of the contact-time law, is not in it "
             "(`contact_time_sigma_s`)",
             positive_up_to(kTimeRange_s.greatest)),
      column("amplitude", &O::amplitude, "Peak of the impact's sound, full scale = 1", {0.0, 1e30}),
      column("snr_db", &O::snr_db, "`amplitude` over the noise rms [dB]"),
      column("flags", &O::flags, "See below"),
      column("probability", &O::probability,
             "That this mark is an impact of this ball: that of the drop, odds/(1 + odds), times that of the impact "
             "given the drop and that of its place. Empty: not known (a table of an earlier version, a mark made by "
             "hand). Below one half the mark is flagged `improbable`",
             {0.0, 1.0}),
      column("errors", &O::errors,
             "`digits`: the standard error is that of the digits alone; the fit finds how much larger it is"),
      column("fall_m", &O::fall_m,
             "Height that the ball fell from before the impact, where heights were measured; `t_s` is then that of "
             "such flights without air",
             positive_up_to(1e4)),
      column("sigma_fall_m", &O::sigma_fall_m, "Its standard error", positive_up_to(1e4))};
  return all;
}

namespace {

/// The step of the coarsest grid of 10 to 1000 places a second, or 1000/1001 of that as of video, on which all times of
/// a drop lie; absent where chance would put as many times so near to one of them.
/// @param digit_s  unit of the times' last digit
std::optional<double> grid_step_s(std::span<const Onset> drop, double digit_s) {
  constexpr double kByChance = 1e-6;
  if (drop.size() < 3) return std::nullopt;  // no coefficient of restitution
  for (int rate_hz = 10; rate_hz <= 1000; ++rate_hz)
    for (const double step_s : {1.0 / rate_hz, 1.001 / rate_hz}) {
      const double within = (digit_s + 1e-9) / step_s;  // two roundings of half a digit
      const double n_tried = 2.0 * rate_hz;
      if (n_tried * std::pow(2.0 * within, static_cast<double>(drop.size()) - 1.0) > kByChance) return std::nullopt;
      const auto is_on_grid = [&](const Onset& onset) {
        const double place = (onset.t_s - drop.front().t_s) / step_s;
        return std::abs(place - std::round(place)) <= within;
      };
      if (std::all_of(drop.begin(), drop.end(), is_on_grid)) return step_s;
    }
  return std::nullopt;
}

/// Times of a drop that has no standard errors are as accurate as its digits, or as the grid that more digits hide:
/// frames of a video as 0.366667 s.
void state_rounding(std::span<Onset> drop, std::optional<double> rounding, int decimals) {
  std::optional<double> sigma_t_s = rounding;
  // of numbers that were no texts all digits are known
  const auto step_s = grid_step_s(drop, decimals < 0 ? 0.0 : std::pow(10.0, -decimals));
  if (step_s) sigma_t_s = std::max(rounding.value_or(0.0), *step_s / std::sqrt(12.0));
  for (Onset& onset : drop)
    if (!onset.sigma_t_s) onset.sigma_t_s = sigma_t_s, onset.errors = sigma_t_s ? kOfDigits : "";
}

}  // namespace

Table to_table(const Onsets& onsets) {
  Table table = table_of<Onset>(columns_of(onsets.data()), onsets);
  const auto no_onset = [&](auto has) { return std::none_of(onsets.begin(), onsets.end(), has); };
  const bool no_heights = no_onset([](const Onset& onset) { return onset.fall_m.has_value(); });
  const bool no_errors = no_onset([](const Onset& onset) { return !onset.errors.empty(); });
  std::erase_if(table.columns, [&](const Column& column) {
    return (no_heights && (column.name == "fall_m" || column.name == "sigma_fall_m")) ||
           (no_errors && column.name == "errors");
  });
  return table;
}

std::vector<ColumnSpec> onset_columns() { return specs_of(columns_of(static_cast<const Onset*>(nullptr))); }

Onsets onsets_from_table(const Table& table, const std::string& name, const Onset* before) {
  check_columns(table, onset_columns(), name);
  Onsets onsets = rows_of(columns_of(static_cast<const Onset*>(nullptr)), table);
  const bool is_numbered = table.integers("impact") != nullptr;
  for (std::size_t k = 0; k < onsets.size(); ++k) {
    Onset& onset = onsets[k];
    const bool goes_on = before && before->recording == onset.recording && before->drop == onset.drop;
    if (goes_on && onset.t_s <= before->t_s)
      throw FileError(name, table.place_of(k) + ", column t_s: times must increase within a drop, but " +
                                std::to_string(onset.t_s) + " follows " + std::to_string(before->t_s) +
                                (onset.t_s == before->t_s
                                     ? "; leave one out, or end the drop before its times are as close as their digits"
                                     : "; is this another drop (with a number of its own in the column drop), or are "
                                       "these intervals (--as intervals)?"));
    if (!is_numbered) onset.impact = goes_on ? before->impact + 1 : 0;
    before = &onset;
  }
  const Column& times = *table.find("t_s");
  for (std::size_t begin = 0, end = 0; begin < onsets.size(); begin = end) {
    const Onset& first = onsets[begin];
    while (end < onsets.size() && onsets[end].recording == first.recording && onsets[end].drop == first.drop) ++end;
    state_rounding(std::span(onsets).subspan(begin, end - begin), times.rounding(), times.decimals);
  }
  for (Onset& onset : onsets)
    if (onset.fall_m && !onset.sigma_fall_m)
      onset.sigma_fall_m = table.find("fall_m")->rounding(), onset.errors = onset.sigma_fall_m ? kOfDigits : "";
  return onsets;
}

void DropsInTurn::check(const Table& table, const std::string& name) {
  const std::vector<std::int64_t>*drops = table.integers("drop"), *impacts = table.integers("impact");
  const std::vector<std::string>* recordings = table.texts("recording");
  for (std::size_t k = 0; drops && k < drops->size(); ++k) {
    const Drop drop{recordings ? (*recordings)[k] : std::string(), (*drops)[k]};
    const auto refuse = [&](const std::string& what) {
      throw FileError(name, table.place_of(k) + ": " + what + " of drop " + std::to_string(drop.second) +
                                (drop.first.empty() ? "" : " of '" + printable(drop.first) + "'") +
                                "; sort the table by recording, drop and impact, and let no row stand twice");
    };
    if (drop != now_) {
      if (now_) done_.insert(*std::exchange(now_, std::nullopt));
      if (done_.contains(drop)) refuse("other rows stand before this one");
      now_ = drop;
      impact_.reset();
    }
    if (!impacts) continue;
    if (impact_ && (*impacts)[k] <= *impact_)
      refuse("impact " + std::to_string((*impacts)[k]) + " follows " + std::to_string(*impact_));
    impact_ = (*impacts)[k];
  }
}

}  // namespace bouncelab
