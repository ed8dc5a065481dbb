// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

/// A word of a column that joins several by '|', and the member that it sets.
struct ConditionWord {
  const char* word;
  bool SampleConditions::*member;
};
constexpr std::array<ConditionWord, 3> kCorrections{{{"drag", &SampleConditions::drag_corrected},
                                                     {"contact_time", &SampleConditions::contact_time_corrected},
                                                     {"travel_time", &SampleConditions::travel_time_corrected}}};
constexpr std::array<ConditionWord, 2> kMeasured{
    {{"heights", &SampleConditions::of_heights}, {"digits", &SampleConditions::sigma_is_least}}};

/// @throws InvalidArgument where a word is none of them
void read_words(const std::string& text, const std::string& name, std::span<const ConditionWord> words,
                SampleConditions& conditions) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('|', begin), text.size());
    const std::string said = text.substr(begin, end - begin);
    const auto known =
        std::find_if(words.begin(), words.end(), [&](const ConditionWord& one) { return said == one.word; });
    if (known == words.end()) {
      std::string all;
      for (const ConditionWord& one : words) all += (all.empty() ? "" : ", ") + std::string(one.word);
      throw InvalidArgument("column " + name + ": '" + printable(said) + "' is none of " + all + "; join them by |");
    }
    conditions.*(known->member) = true;
    begin = end + 1;
  }
}

RowColumn<RestitutionSample> column_of_words(const std::string& name, std::span<const ConditionWord> words,
                                             std::string text) {
  RowColumn<RestitutionSample> made{{name, ColumnType::text, false}, std::move(text), {}};
  made.write = [=](std::span<const RestitutionSample> rows) {
    std::vector<std::string> cells(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (const auto& [word, member] : words)
        if (rows[k].conditions.*member) cells[k] += (cells[k].empty() ? "" : "|") + std::string(word);
    return Column{name, std::move(cells)};
  };
  made.read = [=](const Table& table, std::span<RestitutionSample> rows) {
    const std::vector<std::string>* cells = table.texts(name);
    for (std::size_t k = 0; cells && k < rows.size(); ++k) try {
        read_words((*cells)[k], name, words, rows[k].conditions);
      } catch (const InvalidArgument& error) {
        throw InvalidArgument(table.place_of(k) + ", " + error.what());
      }
  };
  return made;
}

/// A column of descriptions: nearly always that of the row before, which need not be written or understood again.
template <class Thing>
RowColumn<RestitutionSample> described(const std::string& name, std::optional<Thing> SampleConditions::*member,
                                       std::string (*to_text)(const Thing&), Thing (*from_text)(const std::string&),
                                       std::string text) {
  RowColumn<RestitutionSample> made{{name, ColumnType::text, false}, std::move(text), {}};
  made.write = [=](std::span<const RestitutionSample> rows) {
    std::vector<std::string> cells;
    const std::optional<Thing>* before = nullptr;
    for (const RestitutionSample& row : rows) {
      const std::optional<Thing>& thing = row.conditions.*member;
      cells.push_back(before && *before == thing ? cells.back() : thing ? to_text(*thing) : "");
      before = &thing;
    }
    return Column{name, std::move(cells)};
  };
  made.read = [=](const Table& table, std::span<RestitutionSample> rows) {
    const std::vector<std::string>* cells = table.texts(name);
    for (std::size_t k = 0; cells && k < rows.size(); ++k) {
      std::optional<Thing>& thing = rows[k].conditions.*member;
      if (k > 0 && (*cells)[k] == (*cells)[k - 1]) {
        thing = rows[k - 1].conditions.*member;
        continue;
      }
      try {
        if (!(*cells)[k].empty()) thing = from_text((*cells)[k]);
      } catch (const InvalidArgument& error) {
        throw InvalidArgument(table.place_of(k) + ": " + error.what());
      }
    }
  };
  return made;
}

/// Of samples that the fit takes. Orders of magnitude above what any ball does: what is beyond is a fault of the table,
/// and one such row would outweigh all others. A flagged sample may be of a pair of intervals that are no pair.
constexpr Range kUsedSpeed_mps = positive_up_to(1e4);
constexpr Range kUsedEps{-1e3, 1e3};  // the fit warns of negative ones
constexpr Range kSigma{0.0, 1e9};     // 0: not known

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

const RowColumns<RestitutionSample>& columns_of(const RestitutionSample*) {
  using S = RestitutionSample;
  static const RowColumns<S> all{
      recording_column<S>(),
      column("drop", &S::drop, "Drop within the recording", kIndexRange),
      column("impact", &S::impact, "The impact at the end of the first of the two intervals", kIndexRange),
      column("t_s", &S::t_s, "Its time", {kTimeRange_s.least, kTimeRange_s.greatest}),
      column("v_mps", &S::v_mps, "Normal impact speed, g T / 2; of impact 0 that of a fall from the height given")
          .required(),
      column("eps", &S::eps, "Coefficient of restitution; may exceed 1, never clamped").required(),
      column("sigma_v_mps", &S::sigma_v_mps,
             "Standard error of `v_mps` from timing alone, of impact 0 from the height; empty or 0: not known", kSigma),
      column(
          "sigma_eps", &S::sigma_eps,
          "Standard error of `eps` from timing alone, of impact 0 also from the height; empty or 0: not known (the fit "
          "then neglects it, and says so)",
          kSigma),
      column("flags", &S::flags,
             "`missing_impact` or `extra_impact`: the ratio jumps as where an impact was missed or invented, or the "
             "sample is of a rattle that follows the bounces; `not_finite`: set on reading. Flagged samples stay in "
             "the table and out of the fit. A word that is none "
             "of these excludes a sample too; the fit warns of it"),
      column_of_words("corrected", kCorrections,
                      "What is not in the intervals, because it was taken out or there was none: `drag`, "
                      "`contact_time`, `travel_time`, joined by `\\|`; of the others the fit takes account"),
      column_of_words("measured", kMeasured,
                      "`heights`: `v_mps` is √(2 g h) and `eps` √(h'/h), of the heights before and after the impact, "
                      "else by intervals; `digits`: standard errors are of the digits alone, and the fit finds how "
                      "much larger they are"),
      described<Ball>("ball", &SampleConditions::ball, to_text, ball_from_text,
                      "[Description](#balls-and-plates), where it was named: for its drag and contact time"),
      described<Material>("plate", &SampleConditions::plate, plate_text, plate_from_text, "Likewise"),
      column<S>(
          "gravity_mps2", [](auto& s) -> auto& { return s.conditions.gravity_mps2; }, "Of the speeds",
          positive_up_to(1e4)),
      column<S>(
          "air_kgpm3", [](auto& s) -> auto& { return s.conditions.air_kgpm3; }, "Density of the air", Range{0.0, 1e3}),
      column<S>(
          "wave_speed_mps", [](auto& s) -> auto& { return s.conditions.wave_speed_mps; },
          "Of the sound from impact to sensor", positive_up_to(1e6))};
  return all;
}

Table to_table(std::span<const RestitutionSample> samples) {
  return table_of<RestitutionSample>(columns_of(samples.data()), samples);
}

std::vector<ColumnSpec> sample_columns() {
  return specs_of(columns_of(static_cast<const RestitutionSample*>(nullptr)));
}

RestitutionSamples samples_from_table(const Table& table, const std::string& name) {
  check_columns(table, sample_columns(), name);
  RestitutionSamples samples;
  try {
    samples = rows_of(columns_of(static_cast<const RestitutionSample*>(nullptr)), table);
  } catch (const InvalidArgument& error) {  // of a ball or a plate
    throw FileError(name, error.what());
  }
  const bool is_numbered = table.integers("impact") != nullptr;
  const std::optional<double> rounding = table.find("eps")->rounding();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    RestitutionSample& s = samples[k];
    if (!is_numbered) s.impact = static_cast<std::int64_t>(k);
    // as other programs write what is not known
    if (s.sigma_v_mps == 0.0) s.sigma_v_mps.reset();
    if (s.sigma_eps.value_or(0.0) == 0.0) s.sigma_eps = rounding;
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) s.flags.add(Flag::not_finite);
    check_used(s, table.place_of(k), name);
  }
  return samples;
}

}  // namespace bouncelab
