// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/samples.hpp"

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "tables/optional_cells.hpp"

namespace bouncelab {
namespace {

/// The words of the column `corrected`.
struct CorrectionWord {
  const char* word;
  bool SampleConditions::*corrected;
};
constexpr CorrectionWord kCorrections[] = {{"drag", &SampleConditions::drag_corrected},
                                           {"contact_time", &SampleConditions::contact_time_corrected},
                                           {"travel_time", &SampleConditions::travel_time_corrected}};

std::string corrected_text(const SampleConditions& conditions) {
  std::string text;
  for (const auto& [word, corrected] : kCorrections)
    if (conditions.*corrected) text += (text.empty() ? "" : "|") + std::string(word);
  return text;
}

void read_corrected(const std::string& text, SampleConditions& conditions) {
  const std::string words = "|" + text + "|";
  for (const auto& [word, corrected] : kCorrections)
    conditions.*corrected = words.find("|" + std::string(word) + "|") != std::string::npos;
}

/// The numbers of the conditions, by column.
struct ConditionColumn {
  const char* name;
  std::optional<double> SampleConditions::*member;
  double greatest;
};
constexpr ConditionColumn kConditionColumns[] = {{"gravity_mps2", &SampleConditions::gravity_mps2, 1e4},
                                                 {"wave_speed_mps", &SampleConditions::wave_speed_mps, 1e6}};

/// Descriptions as cells: nearly always that of the row before, which need not be written or understood again.
template <class Value>
class Descriptions {
 public:
  std::string text_of(const std::optional<Value>& value, std::string (*to_text)(const Value&)) {
    if (value != value_) {
      value_ = value;
      text_ = value ? to_text(*value) : "";
    }
    return text_;
  }

  /// @throws FileError
  std::optional<Value> value_of(const std::string& text, Value (*from_text)(const std::string&),
                                const std::string& place, const std::string& name) {
    if (text == text_) return value_;
    try {
      value_ = text.empty() ? std::nullopt : std::optional(from_text(text));
    } catch (const InvalidArgument& error) {
      throw FileError(name, place + ": " + error.what());
    }
    text_ = text;
    return value_;
  }

 private:
  std::optional<Value> value_;
  std::string text_;
};

/// Of samples that the fit takes. Orders of magnitude above what any ball does: what is beyond is a fault of the table,
/// and one such row would outweigh all others. A flagged sample may be of a pair of intervals that are no pair.
constexpr Range kUsedSpeed_mps = positive_up_to(1e4);
constexpr Range kUsedEps{-1e3, 1e3};  // the fit warns of negative ones
constexpr Range kSigma{0.0, 1e9};     // the fit takes 0 for not known, and says so

/// @throws FileError
void check_used(const RestitutionSample& s, const std::string& place, const std::string& name) {
  if (!s.flags.empty() || s.v_mps <= 0.0) return;
  const auto require = [&](const char* column, double value, const Range& range) {
    if (!range.holds(value))
      throw FileError(name, place + ", column " + column + ": " + range.why_not(value) + ", or flag the row");
  };
  require("v_mps", s.v_mps, kUsedSpeed_mps);
  require("eps", s.eps, kUsedEps);
}

}  // namespace

void name_ball(RestitutionSamples& samples, const std::optional<Ball>& ball, const std::optional<Material>& plate) {
  for (RestitutionSample& s : samples) {
    if (ball) s.conditions.ball = ball;
    if (plate) s.conditions.plate = plate;
  }
}

Table to_table(const RestitutionSamples& samples) {
  std::vector<std::string> recording, flags, corrected, ball, plate;
  Descriptions<Ball> balls;
  Descriptions<Material> plates;
  std::vector<std::int64_t> drop, impact;
  std::vector<double> t, v, eps, sigma_v, sigma_eps;
  for (const RestitutionSample& s : samples) {
    recording.push_back(recording_cell(s.recording));
    drop.push_back(s.drop);
    impact.push_back(s.impact);
    t.push_back(s.t_s);
    v.push_back(s.v_mps);
    eps.push_back(s.eps);
    sigma_v.push_back(cell_of(s.sigma_v_mps));
    sigma_eps.push_back(cell_of(s.sigma_eps));
    flags.push_back(s.flags.text());
    corrected.push_back(corrected_text(s.conditions));
    ball.push_back(balls.text_of(s.conditions.ball, to_text));
    plate.push_back(plates.text_of(s.conditions.plate, plate_text));
  }
  Table table{{{"recording", std::move(recording)},
               {"drop", std::move(drop)},
               {"impact", std::move(impact)},
               {"t_s", std::move(t)},
               {"v_mps", std::move(v)},
               {"eps", std::move(eps)},
               {"sigma_v_mps", std::move(sigma_v)},
               {"sigma_eps", std::move(sigma_eps)},
               {"flags", std::move(flags)},
               {"corrected", std::move(corrected)},
               {"ball", std::move(ball)},
               {"plate", std::move(plate)}}};
  for (const auto& column : kConditionColumns) {
    std::vector<double> values;
    for (const RestitutionSample& s : samples) values.push_back(cell_of(s.conditions.*column.member));
    table.columns.push_back({column.name, std::move(values)});
  }
  return table;
}

std::vector<ColumnSpec> sample_columns() {
  std::vector<ColumnSpec> columns{{"recording", ColumnType::text, false},
                                  {"drop", ColumnType::integer, false, kIndexRange},
                                  {"impact", ColumnType::integer, false, kIndexRange},
                                  {"t_s", ColumnType::real, false, {kTimeRange_s.least, kTimeRange_s.greatest}},
                                  {"v_mps", ColumnType::real},
                                  {"eps", ColumnType::real},
                                  {"sigma_v_mps", ColumnType::real, false, kSigma},
                                  {"sigma_eps", ColumnType::real, false, kSigma},
                                  {"flags", ColumnType::text, false},
                                  {"corrected", ColumnType::text, false},
                                  {"ball", ColumnType::text, false},
                                  {"plate", ColumnType::text, false}};
  for (const auto& column : kConditionColumns)
    columns.push_back({column.name, ColumnType::real, false, positive_up_to(column.greatest)});
  return columns;
}

RestitutionSamples samples_from_table(const Table& table, const std::string& name) {
  check_columns(table, sample_columns(), name);
  const auto& v = *table.reals("v_mps");
  const auto& eps = *table.reals("eps");
  const auto* recording = table.texts("recording");
  const auto* drop = table.integers("drop");
  const auto* impact = table.integers("impact");
  const auto* t = table.reals("t_s");
  const auto* flags = table.texts("flags");
  const auto* corrected = table.texts("corrected");
  const auto* ball = table.texts("ball");
  const auto* plate = table.texts("plate");
  Descriptions<Ball> balls;
  Descriptions<Material> plates;
  RestitutionSamples samples(v.size());
  for (std::size_t k = 0; k < v.size(); ++k) {
    RestitutionSample& s = samples[k];
    if (recording) s.recording = (*recording)[k];
    if (drop) s.drop = (*drop)[k];
    s.impact = impact ? (*impact)[k] : static_cast<std::int64_t>(k);
    if (t) s.t_s = (*t)[k];
    s.v_mps = v[k];
    s.eps = eps[k];
    s.sigma_v_mps = optional_cell(table.reals("sigma_v_mps"), k);
    s.sigma_eps = optional_cell(table.reals("sigma_eps"), k);
    if (flags) s.flags = Flags::from_text((*flags)[k]);
    if (corrected) read_corrected((*corrected)[k], s.conditions);
    if (ball) s.conditions.ball = balls.value_of((*ball)[k], ball_from_text, table.place_of(k), name);
    if (plate) s.conditions.plate = plates.value_of((*plate)[k], plate_from_text, table.place_of(k), name);
    for (const auto& column : kConditionColumns)
      s.conditions.*column.member = optional_cell(table.reals(column.name), k);
    if (!std::isfinite(v[k]) || !std::isfinite(eps[k])) s.flags.add(Flag::not_finite);
    check_used(s, table.place_of(k), name);
  }
  return samples;
}

}  // namespace bouncelab
