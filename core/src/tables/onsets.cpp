// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/onsets.hpp"

#include <cassert>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "tables/optional_cells.hpp"

namespace bouncelab {

std::string_view name_of(Flag flag) {
  switch (flag) {
    case Flag::by_hand:
      return "by_hand";
    case Flag::clipped:
      return "clipped";
    case Flag::doubtful:
      return "doubtful";
    case Flag::extra_impact:
      return "extra_impact";
    case Flag::inferred:
      return "inferred";
    case Flag::missing_impact:
      return "missing_impact";
    case Flag::no_position:
      return "no_position";
    case Flag::not_finite:
      return "not_finite";
    case Flag::overlap:
      return "overlap";
  }
  assert(false);
  return {};
}

std::optional<Flag> flag_named(std::string_view word) {
  for (const Flag flag : {Flag::by_hand, Flag::clipped, Flag::doubtful, Flag::extra_impact, Flag::inferred,
                          Flag::missing_impact, Flag::no_position, Flag::not_finite, Flag::overlap})
    if (name_of(flag) == word) return flag;
  return std::nullopt;
}

Flags::Flags(std::initializer_list<Flag> flags) {
  for (const Flag flag : flags) add(flag);
}

Flags Flags::from_text(std::string text) {
  Flags flags;
  flags.text_ = std::move(text);
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

Table to_table(const Onsets& onsets) {
  std::vector<std::string> recording, flags;
  std::vector<std::int64_t> drop, impact;
  std::vector<double> t, sigma, amplitude, snr, probability;
  for (const Onset& o : onsets) {
    recording.push_back(recording_cell(o.recording));
    drop.push_back(o.drop);
    impact.push_back(o.impact);
    t.push_back(o.t_s);
    sigma.push_back(cell_of(o.sigma_t_s));
    amplitude.push_back(cell_of(o.amplitude));
    snr.push_back(cell_of(o.snr_db));
    flags.push_back(o.flags.text());
    probability.push_back(cell_of(o.probability));
  }
  return {{{"recording", std::move(recording)},
           {"drop", std::move(drop)},
           {"impact", std::move(impact)},
           {"t_s", std::move(t)},
           {"sigma_t_s", std::move(sigma)},
           {"amplitude", std::move(amplitude)},
           {"snr_db", std::move(snr)},
           {"flags", std::move(flags)},
           {"probability", std::move(probability)}}};
}

std::vector<ColumnSpec> onset_columns() {
  return {{"recording", ColumnType::text, false},
          {"drop", ColumnType::integer, false, kIndexRange},
          {"impact", ColumnType::integer, false, kIndexRange},
          {"t_s", ColumnType::real, true, known(kTimeRange_s)},
          {"sigma_t_s", ColumnType::real, false, positive_up_to(kTimeRange_s.greatest)},
          {"amplitude", ColumnType::real, false, {0.0, 1e30}},
          {"snr_db", ColumnType::real, false},
          {"flags", ColumnType::text, false},
          {"probability", ColumnType::real, false, {0.0, 1.0}}};
}

Onsets onsets_from_table(const Table& table, const std::string& name, const Onset* before) {
  check_columns(table, onset_columns(), name);
  const auto& t = *table.reals("t_s");
  const auto* recording = table.texts("recording");
  const auto* drop = table.integers("drop");
  const auto* impact = table.integers("impact");
  const auto* flags = table.texts("flags");
  Onsets onsets;
  onsets.reserve(t.size());
  for (std::size_t k = 0; k < t.size(); ++k) {
    Onset onset;
    if (recording) onset.recording = (*recording)[k];
    if (drop) onset.drop = (*drop)[k];
    const bool goes_on = before && before->recording == onset.recording && before->drop == onset.drop;
    if (goes_on && t[k] <= before->t_s)
      throw FileError(name, table.place_of(k) + ", column t_s: times must increase within a drop, but " +
                                std::to_string(t[k]) + " follows " + std::to_string(before->t_s) + "; sort the file");
    onset.impact = impact ? (*impact)[k] : (goes_on ? before->impact + 1 : 0);
    onset.t_s = t[k];
    onset.sigma_t_s = optional_cell(table.reals("sigma_t_s"), k);
    onset.amplitude = optional_cell(table.reals("amplitude"), k);
    onset.snr_db = optional_cell(table.reals("snr_db"), k);
    onset.probability = optional_cell(table.reals("probability"), k);
    if (flags) onset.flags = Flags::from_text((*flags)[k]);
    onsets.push_back(std::move(onset));
    before = &onsets.back();
  }
  return onsets;
}

}  // namespace bouncelab
