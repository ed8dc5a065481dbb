// SPDX-License-Identifier: GPL-3.0-or-later
// Times and intervals of other people's tables.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"
#include "tables/foreign_sequence.hpp"

namespace bouncelab {
namespace {

constexpr std::array<std::string_view, 6> kFrameWords{"frame", "frames", "sample", "samples", "bild", "image"};

std::vector<double> roundings_of(const std::vector<Found>& values) {
  std::vector<double> roundings;
  for (const Found& value : values) roundings.push_back(value.rounding);
  return roundings;
}

/// Do the numbers fall more often than they rise? Times rise, but where a new drop begins; intervals fall.
bool fall(const Sequence& sequence) {
  int n = 0;
  for (std::size_t k = 1; k < sequence.values.size(); ++k) {
    const Found &a = sequence.values[k - 1], &b = sequence.values[k];
    if (!sequence.has_series || a.series == b.series) n += b.value < a.value ? 1 : b.value > a.value ? -1 : 0;
  }
  return n > 0;
}

/// Seconds per unit of the numbers.
double unit_of(const Sequence& sequence, bool are_intervals, const ForeignOptions& options, const std::string& name,
               std::string& in_words) {
  if (sequence.values.front().is_clock) return in_words = "clock times", 1.0;
  const auto said = [&](double unit_s) {
    constexpr std::array<std::pair<double, const char*>, 7> kNames{
        {{3600.0, "h"}, {60.0, "min"}, {1.0, "s"}, {0.1, "ds"}, {1e-2, "cs"}, {1e-3, "ms"}, {1e-6, "us"}}};
    const auto named = std::find_if(kNames.begin(), kNames.end(), [&](const auto& n) { return n.first == unit_s; });
    in_words = named == kNames.end() ? "ns" : named->second;
    return unit_s;
  };
  if (options.unit != "auto") return said(*time_unit_s(options.unit));
  const auto titled_s = time_unit_s(sequence.title);
  if (!titled_s && has_word(sequence.title, kFrameWords))
    throw FileError(name, sequence.from +
                              " counts frames or samples: divide it by how many there are in a second, or "
                              "name another column (--columns t=COLUMN)");
  std::vector<double> lengths;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    if (are_intervals)
      lengths.push_back(std::abs(sequence.values[k].value));
    else if (k > 0)
      lengths.push_back(std::abs(sequence.values[k].value - sequence.values[k - 1].value));
  }
  // flights of 20 ms to 10 s have a median that tells s and ms apart
  const double typical = lengths.empty() ? 0.0 : median(std::move(lengths));
  constexpr double kShortest_s = 1e-3;  // a bounce as high as a bacterium is long
  if (titled_s && typical > 0.0 && typical * *titled_s < kShortest_s)
    throw FileError(name,
                    sequence.from + " has intervals of " + short_number(typical * *titled_s) +
                        " s in the median, which no ball has: is its unit right, or does a comma part thousands?");
  if (titled_s) return said(*titled_s);
  if (typical <= 10.0) return said(1.0);
  if (typical >= 20.0 && typical <= 1e4) return said(1e-3);
  throw FileError(name,
                  "has intervals of " + short_number(typical) + " in a unit that is not named; give --unit ms or us");
}

struct Times {
  std::vector<double> t_s;
  std::vector<std::int64_t> drop;
};

Times times_of_times(const Sequence& sequence, double unit_s) {
  Times times;
  for (const Found& found : sequence.values) {
    times.t_s.push_back(unit_s * found.value);
    times.drop.push_back(found.series);
  }
  if (!sequence.has_series) times.drop = drops_of(times.t_s);
  return times;
}

/// Each drop's first impact is at 0.
Times times_of_intervals(const Sequence& sequence, double unit_s) {
  constexpr double kGrown = 1.5;  // of one ball's flights none is so much longer than that before it
  Times times;
  std::int64_t drop = 0;
  double t_s = 0.0;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const Found& here = sequence.values[k];
    const bool begins = k == 0 || (sequence.has_series ? here.series != sequence.values[k - 1].series
                                                       : here.value > kGrown * sequence.values[k - 1].value);
    if (begins) {
      drop += k == 0 ? 0 : 1;
      t_s = 0.0;
      times.t_s.push_back(t_s);
      times.drop.push_back(drop);
    }
    t_s += unit_s * here.value;
    times.t_s.push_back(t_s);
    times.drop.push_back(drop);
  }
  return times;
}

}  // namespace

std::vector<std::int64_t> drops_of(std::span<const double> t_s) {
  std::vector<std::int64_t> drops;
  double interval_s = 0.0, before_s = 0.0;
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    const double here_s = k == 0 ? 0.0 : t_s[k] - t_s[k - 1];
    // a mark too many parts an interval in two, of which one may be short
    const double longer_s = std::max(interval_s, before_s);
    const bool begins = k > 0 && (here_s < 0.0 || (longer_s > 0.0 && here_s > kMissed * longer_s));
    drops.push_back(k == 0 ? 0 : drops.back() + (begins ? 1 : 0));
    before_s = begins ? 0.0 : interval_s;
    interval_s = begins ? 0.0 : here_s;
  }
  return drops;
}

TakenTable onsets_from_foreign(const ForeignTable& foreign, const std::string& name, const ForeignOptions& options) {
  check_one_ball(foreign, name);
  const std::optional<Sequence> rows = options.columns.empty() ? rows_of_values(foreign, name) : std::nullopt;
  if (holds_samples(foreign) && options.as == "auto" && options.columns.empty())
    throw FileError(name, "holds speeds and coefficients of restitution, no times; bouncelab fit takes it");
  if (!rows && uniform_step_s(foreign) && options.as == "auto")
    throw FileError(name,
                    "has times that are equally spaced, as the frames of a video: impact times are needed; leave "
                    "the frames of the impacts only, or say --as times");
  const Sequence sequence = rows ? *rows : column_of_values(foreign, options, name);
  if (sequence.values.empty()) throw FileError(name, "holds no times or intervals");
  const bool told = options.as != "auto", numbers_fall = fall(sequence);
  const bool are_intervals = told ? options.as == "intervals" : sequence.says_intervals || numbers_fall;
  std::string unit;
  const double unit_s = unit_of(sequence, are_intervals, options, name, unit);
  for (const Found& value : sequence.values)
    if (are_intervals && !(value.value > 0.0))
      throw FileError(name, "line " + std::to_string(value.line) + ": an interval of " + short_number(value.value) +
                                "; intervals are above 0. " +
                                (sequence.says_intervals ? "Leave those out that are as short as their last digit"
                                                         : "Are these times? Say --as times"));
  Times times = are_intervals ? times_of_intervals(sequence, unit_s) : times_of_times(sequence, unit_s);
  const std::int64_t n_drops = times.drop.back() + 1;

  TakenTable taken;
  const std::size_t n_impacts = times.t_s.size();
  taken.table.columns.push_back({"drop", std::move(times.drop)});
  taken.table.columns.push_back({"t_s", std::move(times.t_s), decimals_of(roundings_of(sequence.values), unit_s)});
  if (!are_intervals && !rows && n_impacts == foreign.rows.size()) {
    std::vector<ColumnSpec> own = onset_columns();
    std::erase_if(own, [](const ColumnSpec& spec) { return spec.type == ColumnType::integer; });  // numbered anew
    add_own_columns(foreign, own, name, taken.table);
  }
  for (std::size_t k = 0; k < n_impacts && !are_intervals; ++k) taken.table.stands_on(k, sequence.values[k].line);
  std::string how = format_in_words(foreign.format, foreign.n_columns());
  if (!sequence.from.empty()) how = sequence.from + (how.empty() ? "" : ", " + how);
  taken.taken_for = std::string(are_intervals ? "intervals" : "times") + (unit == "clock times" ? ", " : " in ") +
                    unit + (how.empty() ? "" : " (" + how + ")") + ": " + std::to_string(n_impacts) + " impacts in " +
                    std::to_string(n_drops) + (n_drops == 1 ? " drop" : " drops");
  if (are_intervals && !told && !sequence.says_intervals)
    taken.taken_for += "; they fall, so they are no times (--as times if they are)";
  if (foreign.n_left_out > 0)
    taken.taken_for += "; " + std::to_string(foreign.n_left_out) + " lines without numbers left out";
  if (sequence.n_left_out > 0)
    taken.taken_for += "; " + std::to_string(sequence.n_left_out) + (sequence.n_left_out == 1 ? " row" : " rows") +
                       " of means or deviations left out";
  return taken;
}

}  // namespace bouncelab
