// SPDX-License-Identifier: GPL-3.0-or-later
// Times and intervals of other people's tables. The rule, whole (docs/formats.md, "Files of other programs"):
//
//   the column: --columns t=...; else our t_s; else the one whose title has a unit of time, or whose cells are clock
//               times, dates with times, or seconds (ms, us, ns) since 1970; else, untitled, the only column or row
//   its unit:   the cells', --unit, the title's; else seconds, if the speeds that follow are those of balls
//   what it is: --as; else intervals, if its title is dt, Delta t or interval; else times, if they rise, or rise again
//               in each drop for three impacts or more
//   its drops:  --columns drop=... or a column called drop; else a new one begins behind a blank line, where times go
//               back or pause (drops_of), where an interval is half as long again as the one before
//
// Everything else is asked: two columns of one dimension, a column beside them that may tell other drops, numbers that
// fall, equal steps, speeds of no ball.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_sequence.hpp"

namespace bouncelab {
namespace {

/// --columns with this column of times, and what was told of drops.
std::string with_times(const ForeignTable& table, const ForeignOptions& options, std::size_t column) {
  std::string text = column_option(table, "t", column);
  for (const std::string_view part : cells_of(options.columns, ','))
    if (part.starts_with("drop=")) text += "," + std::string(part);
  return text;
}

constexpr std::array<std::pair<const char*, double>, 3> kTimeUnits{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}}};

bool are_of_a_ball(double interval_s) {
  constexpr double kSlowest_mps = 0.02, kFastest_mps = 30.0, kGravity_mps2 = 9.81;
  const double v_mps = 0.5 * kGravity_mps2 * interval_s;
  return v_mps >= kSlowest_mps && v_mps <= kFastest_mps;
}

/// Do the numbers rise from row to row, or in each drop again, for three impacts or more?
bool rise(const Sequence& sequence) {
  if (sequence.values.empty()) return false;
  constexpr std::size_t kLeast = 3;
  std::size_t n = 1;
  for (std::size_t k = 1; k < sequence.values.size(); ++k) {
    const auto &before = sequence.values[k - 1], &here = sequence.values[k];
    const bool begins = here.part != before.part;
    if (!begins && here.number.value >= before.number.value) {
      ++n;
      continue;
    }
    if (!begins && (n < kLeast || sequence.has_drops)) return false;
    n = 1;
  }
  return sequence.has_drops || sequence.values.back().part > 0 || n >= kLeast || n == sequence.values.size();
}

/// In the median, in the unit of the numbers; 0 of a single time.
double typical_interval(const Sequence& sequence, bool intervals) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const double before = k == 0 || intervals ? 0.0 : sequence.values[k - 1].number.value;
    if (const double length = sequence.values[k].number.value - before; length > 0.0 && (intervals || k > 0))
      lengths.push_back(length);
  }
  return lengths.empty() ? 0.0 : median(std::move(lengths));
}

bool are_equal_steps(const Sequence& sequence, std::size_t least) {
  const auto& values = sequence.values;
  if (values.size() < least) return false;
  const double step = values[1].number.value - values[0].number.value;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (std::abs(values[k].number.value - values[k - 1].number.value - step) >
        0.1 * step + 2.0 * (values[k - 1].number.rounding + values[k].number.rounding))
      return false;
  return step > 0.0;
}

/// What a column without a unit would be: times or intervals of a ball in s, ms or us.
std::optional<Reading> likely_reading(const ForeignTable& table, const ForeignOptions& options, std::size_t column) {
  Sequence sequence;
  for (const ForeignTable::Row& row : table.rows)
    if (const auto number = table.number(row, column)) sequence.values.push_back({*number, row.line, 0});
  const bool are_whole = std::all_of(sequence.values.begin(), sequence.values.end(), [](const Sequence::Value& value) {
    return value.number.value == std::floor(value.number.value);
  });
  if (unit_of(table, column) || sequence.values.size() < 3 || are_equal_steps(sequence, 3) ||
      (are_whole && sequence.values.front().number.value <= 1.0))  // it numbers something
    return std::nullopt;
  const bool times = rise(sequence);
  const auto stands_again = [](const Sequence::Value& a, const Sequence::Value& b) {
    return a.number.value == b.number.value;
  };
  if (times &&
      std::adjacent_find(sequence.values.begin(), sequence.values.end(), stands_again) != sequence.values.end())
    return std::nullopt;
  for (const auto& [unit, unit_s] : kTimeUnits)
    if (are_of_a_ball(unit_s * typical_interval(sequence, !times)))
      return Reading{(times ? "times in " : "intervals in ") + std::string(unit) + " by " + column_name(table, column),
                     told(times ? "times" : "intervals", unit, with_times(table, options, column))};
  return std::nullopt;
}

/// Have all columns the same unit, or none? A height among times of one row is no time.
bool are_alike(const ForeignTable& table) {
  const auto first = unit_of(table, 0);
  for (std::size_t k = 1; k < table.n_columns(); ++k)
    if (const auto unit = unit_of(table, k);
        !table.rows.front().cells[k].empty() &&
        (unit.has_value() != first.has_value() || (unit && unit->name != first->name)))
      return false;
  return true;
}

/// The column of times or intervals; absent: the only row is one.
std::optional<std::size_t> column_of(const ForeignTable& table, const ForeignOptions& options,
                                     const std::string& name) {
  if (const auto column = told_column(table, options, "t", name)) return column;
  std::vector<std::size_t> of_time, measured;
  std::vector<Reading> readings;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const bool is_own = title_of(table, k) == "t_s";
    const auto unit = unit_of(table, k);
    if (!unit) continue;
    measured.push_back(k);
    if (unit->dimension != Dimension::time) continue;
    if (is_own && std::count(table.titles.begin(), table.titles.end(), "t_s") == 1) return k;
    of_time.push_back(k);
    readings.push_back({column_name(table, k), told(options.as, options.unit, with_times(table, options, k))});
  }
  const bool is_row = table.rows.size() == 1 && table.n_columns() > 1 && are_alike(table);
  if (measured.size() == 1 && of_time.size() == 1 && !is_row) {
    // an error (s) or a clock beside times that no unit stands above
    for (std::size_t k = 0; k < table.n_columns(); ++k)
      if (const auto other = likely_reading(table, options, k); other && other->options.as == "times")
        readings.push_back(*other);
    if (readings.size() == 1) return of_time.front();
    ask(table, name, "has a column with a unit of time, and another that rises as times do; which is read?",
        std::move(readings));
  }
  if (is_row && options.as != "auto") return std::nullopt;
  if (is_row && !of_time.empty()) {
    const bool times = rise(row_of_numbers(table, name));
    readings = {
        {times ? "times in a row" : "intervals in a row", told(times ? "times" : "intervals", options.unit, {})}};
  }
  if (of_time.size() > 1)
    ask(table, name,
        std::to_string(of_time.size()) +
            " columns are of a time, and one is read; which? Several drops stand below each other, with a column drop",
        std::move(readings));
  if (measured.size() > 1 && !of_time.empty()) {
    for (const std::size_t k : measured)
      if (!is_row && unit_of(table, k)->dimension == Dimension::length)
        readings.push_back({"heights, one after the other, of " + column_name(table, k),
                            told("heights", options.unit, column_option(table, "h", k))});
    ask(table, name, "has a time and another measured quantity: which is to be read?", std::move(readings));
  }
  if (table.titles.empty() && is_row) return std::nullopt;
  if (table.n_columns() == 1 && (table.titles.empty() || options.as != "auto")) return std::size_t{0};
  if (!measured.empty())
    ask(table, name,
        "no column is a time: " + column_name(table, measured.front()) +
            " is another quantity; bouncelab fit takes speeds and coefficients",
        {});
  for (std::size_t k = 0; k < table.n_columns(); ++k)
    if (const auto reading = likely_reading(table, options, k)) readings.push_back(*reading);
  ask(table, name,
      table.titles.empty() ? "which column is of times or intervals?" : "no title has a unit of time, such as Time (s)",
      std::move(readings));
}

bool names_interval(const std::optional<TitleUnit>& unit) {
  constexpr std::array<std::string_view, 5> kNames{"dt", "\xCE\x94t", "\xE2\x88\x86t", "interval", "Interval"};
  return unit && std::find(kNames.begin(), kNames.end(), unit->quantity) != kNames.end();
}

/// What the numbers are: --as, or what they prove.
bool are_intervals(const ForeignTable& table, const Sequence& sequence, const ForeignOptions& options,
                   const std::string& name) {
  if (options.as != "auto") return options.as == "intervals";
  const bool times = rise(sequence), titled = names_interval(sequence.unit);
  if (titled != times) return titled;
  const std::string how = sequence.column ? "the numbers of " + column_name(table, *sequence.column) : "the numbers";
  std::string question = how + (titled ? " rise, as times do, and their title says intervals"
                                       : " do not rise from row to row, as times do: intervals?");
  std::vector<Reading> readings;
  for (const auto& [unit, unit_s] : kTimeUnits)
    for (const char* as : {"intervals", "times"})
      if (sequence.unit ? unit == kTimeUnits[0].first : are_of_a_ball(unit_s * typical_interval(sequence, *as == 'i')))
        readings.push_back({std::string(as) + " in " + (sequence.unit ? sequence.unit->name : unit),
                            told(as, sequence.unit ? options.unit : unit, options.columns)});
  for (const auto& [unit, unit_m] : {std::pair{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}}) {
    constexpr double kLeast_m = 0.15, kMost_m = 3.5;  // what a ball is dropped from in a room
    const double height_m = unit_m * sequence.values.front().number.value;
    if (!times && !sequence.unit && height_m > kLeast_m && height_m < kMost_m)
      readings.push_back(
          {std::string("heights in ") + unit,
           told("heights", unit,
                sequence.column && !table.titles.empty() ? column_option(table, "h", *sequence.column) : "")});
  }
  ask(table, name, question, std::move(readings));
}

/// Seconds per unit of the numbers.
double unit_s_of(const ForeignTable& table, Sequence& sequence, bool intervals, const ForeignOptions& options,
                 const std::string& name) {
  const bool is_clock = sequence.unit && sequence.unit->name == kClock;
  if (is_clock && options.unit != "auto") return 1.0;  // its cells are in seconds, whatever is said
  for (const auto& [unit, unit_s] : kTimeUnits)
    if (options.unit == unit) return sequence.unit = TitleUnit{Dimension::time, unit_s, unit, {}}, unit_s;
  if (!sequence.unit) sequence.unit = TitleUnit{Dimension::time, 1.0, "s", {}};
  const double unit_s = sequence.unit->si;
  const double typical = typical_interval(sequence, intervals);
  if (typical == 0.0 || are_of_a_ball(unit_s * typical)) return unit_s;
  std::vector<Reading> readings;
  for (const auto& [unit, other_s] : kTimeUnits)
    if (is_clock ? other_s == 1.0 : are_of_a_ball(other_s * typical))
      readings.push_back({std::string("in ") + unit, told(options.as, unit, options.columns)});
  ask(table, name,
      "intervals of " + short_number(typical) + " " + (is_clock ? "s" : sequence.unit->name) +
          " in the median, which no ball has; in which unit are they?",
      std::move(readings));
}

struct Times {
  std::vector<double> t_s;
  std::vector<std::int64_t> drop;
};

Times times_of_times(const Sequence& sequence, double unit_s, const std::string& name) {
  Times times;
  std::vector<double> of_part;
  std::int64_t next = 0;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const Sequence::Value& here = sequence.values[k];
    if (k > 0 && here.number.value == sequence.values[k - 1].number.value && here.part == sequence.values[k - 1].part)
      throw FileError(name, "line " + std::to_string(here.line) +
                                ": the time of the row before it stands again; delete one of the two");
    times.t_s.push_back(unit_s * here.number.value);
    of_part.push_back(times.t_s.back());
    if (k + 1 < sequence.values.size() && sequence.values[k + 1].part == here.part) continue;
    const std::vector<std::int64_t> drops =
        sequence.has_drops ? std::vector<std::int64_t>(of_part.size(), 0) : drops_of(of_part);
    for (const std::int64_t drop : drops) times.drop.push_back(next + drop);
    next = times.drop.back() + 1;
    of_part.clear();
  }
  return times;
}

/// Each drop's first impact is at 0.
Times times_of_intervals(const Sequence& sequence, double unit_s, const std::string& name) {
  constexpr double kGrown = 1.5;  // of one ball's flights none is so much longer than that before it
  Times times;
  std::int64_t drop = -1;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const Sequence::Value& here = sequence.values[k];
    if (!(here.number.value > 0.0))
      throw FileError(name, "line " + std::to_string(here.line) + ": an interval of " +
                                short_number(here.number.value) +
                                "; intervals are above 0: leave it out, or say --as times");
    const bool begins = k == 0 || here.part != sequence.values[k - 1].part ||
                        (!sequence.has_drops && here.number.value > kGrown * sequence.values[k - 1].number.value);
    if (begins) times.t_s.push_back(0.0), times.drop.push_back(++drop);
    times.t_s.push_back(times.t_s.back() + unit_s * here.number.value);
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
    const bool begins =
        k > 0 && (here_s < 0.0 || here_s > kLongestFlight_s || (longer_s > 0.0 && here_s > kMissed * longer_s));
    drops.push_back(k == 0 ? 0 : drops.back() + (begins ? 1 : 0));
    before_s = begins ? 0.0 : interval_s;
    interval_s = begins ? 0.0 : here_s;
  }
  return drops;
}

TakenTable onsets_from_foreign(const ForeignTable& table, const std::string& name, const ForeignOptions& options) {
  if (auto other = heights_from_foreign(table, name, options)) return *std::move(other);
  if (own_column(table, "eps") && own_column(table, "v_mps") && !own_column(table, "t_s") && !options.tells())
    throw FileError(name, "holds speeds and coefficients of restitution, no times; bouncelab fit takes it");
  const std::optional<std::size_t> column = column_of(table, options, name);
  Sequence sequence = column ? column_of_numbers(table, *column, options, name) : row_of_numbers(table, name);
  if (sequence.unit && sequence.unit->dimension != Dimension::time) sequence.unit.reset();
  if (sequence.values.empty()) throw FileError(name, "holds no times or intervals");
  constexpr std::size_t kFrames = 8;  // of a video
  if (options.as == "auto" && are_equal_steps(sequence, kFrames))
    ask(table, name,
        "has times that are equally spaced, as the frames of a video are; impact times are needed: leave "
        "the rows of the impacts only",
        {{"if each is an impact", told("times", options.unit, options.columns)}});
  const bool intervals = are_intervals(table, sequence, options, name);
  const double unit_s = unit_s_of(table, sequence, intervals, options, name);
  Times times = intervals ? times_of_intervals(sequence, unit_s, name) : times_of_times(sequence, unit_s, name);
  if (sequence.column && options.columns.empty() && !sequence.has_drops) {
    std::vector<std::int64_t> drop_of_row(table.rows.size(), -1);
    std::size_t impact = 0;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      if (!table.number(table.rows[row], *sequence.column)) continue;
      if (intervals && (impact == 0 || times.drop[impact] != times.drop[impact - 1])) ++impact;  // its first, at 0
      drop_of_row[row] = times.drop[impact++];
    }
    check_blocks(table, *sequence.column, "t", drop_of_row, options, name);
  }
  TakenTable taken;
  const std::size_t n_impacts = times.t_s.size();
  const std::int64_t n_drops = times.drop.back() + 1;
  taken.table.columns.push_back({"drop", std::move(times.drop)});
  taken.table.columns.push_back({"t_s", std::move(times.t_s), decimals_of(sequence.roundings(), unit_s)});
  if (!intervals && sequence.column && n_impacts == table.rows.size()) {
    std::vector<ColumnSpec> own = onset_columns();
    std::erase_if(own, [](const ColumnSpec& spec) { return spec.type == ColumnType::integer; });  // numbered anew
    add_own_columns(table, own, name, taken.table);
  }
  for (std::size_t k = 0; k < n_impacts && !intervals; ++k) taken.table.stands_on(k, sequence.values[k].line);
  const std::string how = source_in_words(table, sequence);
  taken.taken_for = std::string(intervals ? "intervals" : "times") + (sequence.unit->name == kClock ? " as " : " in ") +
                    sequence.unit->name + (how.empty() ? "" : " (" + how + ")") + ": " + std::to_string(n_impacts) +
                    " impacts in " + std::to_string(n_drops) + (n_drops == 1 ? " drop" : " drops");
  return taken;
}

}  // namespace bouncelab
