// SPDX-License-Identifier: GPL-3.0-or-later
// Times, intervals and heights of other people's tables. The rule, whole (docs/formats.md, "Files of other programs"):
//
//   the column: --columns t=... or h=...; else our t_s; else the one whose title has a unit of time (of length), or
//   whose
//               cells are clock times, dates with times, or seconds (ms, us, ns) since 1970; else, untitled, the only
//               column or row
//   what it is: --as; else heights, if its unit is of length; else intervals, if its title is dt, Delta t or interval;
//               else times, if they rise, or rise again in each drop for three impacts or more
//   its unit:   the cells', --unit, the title's; else seconds, if the speeds that follow are those of balls
//   its drops:  --columns drop=... or a column called drop; else a new one begins behind a blank line, where times go
//               back or pause (drops_of), where an interval is half as long again as the one before
//
// Everything else is asked: two columns of one dimension, a column beside them that may tell other drops, numbers that
// fall, equal steps, speeds of no ball. A question lists the readings that are consistent with all this.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_sequence.hpp"

namespace bouncelab {
namespace {

/// What the numbers are: --as, or what they prove.
std::string meaning_of(const ForeignTable& table, const Selection& selection, const Sequence& sequence,
                       const ForeignOptions& options, const std::string& name) {
  if (selection.dimension == Dimension::length) return "heights";
  if (options.as != "auto") return options.as;
  constexpr std::array<std::string_view, 5> kIntervals{"dt", "\xCE\x94t", "\xE2\x88\x86t", "interval", "Interval"};
  const bool times = rises(sequence), titled = sequence.unit && std::find(kIntervals.begin(), kIntervals.end(),
                                                                          sequence.unit->quantity) != kIntervals.end();
  if (titled != times) return titled ? "intervals" : "times";
  std::vector<const char*> as{"intervals", "times"};
  if (!titled && !sequence.unit) as.push_back("heights");
  std::vector<Reading> readings = readings_of(sequence, as, sequence.unit.has_value(), options, options.columns);
  for (Reading& reading : readings)
    if (reading.options.as == "heights" && !table.titles.empty())
      reading.options.columns = columns_option(table, "h", selection.columns);
  ask(table, name,
      (selection.by_rows || selection.columns.size() > 1
           ? "the numbers"
           : "the numbers of " + column_name(table, selection.columns[0])) +
          (titled ? " rise, as times do, and their title says intervals"
                  : " do not rise from row to row, as times do: intervals?"),
      std::move(readings));
}

TitleUnit unit_of_numbers(const ForeignTable& table, const Sequence& sequence, const std::string& as,
                          const ForeignOptions& options, const std::string& name) {
  const Dimension dimension = as == "heights" ? Dimension::length : Dimension::time;
  const bool is_clock = sequence.unit && sequence.unit->name == kClock, is_told = options.unit != "auto";
  TitleUnit unit = sequence.unit.value_or(TitleUnit{Dimension::time, 1.0, "s", {}});
  if (is_told && !is_clock) unit = unit_called(options.unit);
  if (is_told && unit.dimension != dimension)
    throw InvalidArgument("--unit " + options.unit + ": " + as + " are in " +
                          (as == "heights" ? "m, cm, mm, in or ft" : "s, ms or us"));
  if (is_told || (as == "heights" && sequence.unit)) return unit;
  const bool is_single = as != "heights" && typical_interval(sequence, as == "intervals") == 0.0;
  if (as != "heights" && (is_single || are_of_a_ball(sequence, as, unit.si))) return unit;
  std::vector<Reading> readings = readings_of(sequence, {as.c_str()}, is_clock, options, options.columns);
  for (Reading& reading : readings) {
    reading.options.as = as == "heights" ? as : options.as;
    if (is_clock) reading.options.unit = "s";
  }
  ask(table, name,
      as == "heights" ? "in which unit are the heights?"
                      : "intervals of " + short_number(typical_interval(sequence, as == "intervals")) + " " +
                            (is_clock ? "s" : unit.name) + " in the median, which no ball has; in which unit are they?",
      std::move(readings));
}

struct Times {
  std::vector<double> t_s, fall_m;
  std::vector<std::int64_t> drop, drop_of_value;
  std::string risen, mean;  ///< questions: there may be another drop, a last number was not measured
};

Times times_of_times(const Sequence& sequence, double unit_s, const std::string& name) {
  Times times;
  std::vector<double> of_part;
  std::int64_t next = 0;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const Sequence::Value& here = sequence.values[k];
    if (const NumberCell* before = sequence.before(k); before && here.number.value == before->value)
      throw FileError(name, "line " + std::to_string(here.line) +
                                ": the time of the row before it stands again; delete one of the two");
    times.t_s.push_back(unit_s * here.number.value);
    of_part.push_back(times.t_s.back());
    if (k + 1 < sequence.values.size() && sequence.before(k + 1)) continue;
    const std::vector<std::int64_t> drops =
        sequence.has_drops ? std::vector<std::int64_t>(of_part.size(), 0) : drops_of(of_part);
    for (const std::int64_t drop : drops) times.drop.push_back(next + drop);
    next = times.drop.back() + 1;
    of_part.clear();
  }
  times.drop_of_value = times.drop;
  return times;
}

/// Flights, or the heights of them of which the first is the release: each drop's first impact is at 0.
Times times_of_flights(const Sequence& sequence, double si, bool heights, const std::string& name) {
  // of one ball's flights none is so much longer than that before it; above the second it may be another drop
  const double grown = heights ? 2.25 : 1.5, risen = heights ? 1.2 : grown;
  double rounding = HUGE_VAL;
  for (const Sequence::Value& one : sequence.values) rounding = std::min(rounding, one.number.rounding);
  Times times;
  std::int64_t drop = -1;
  double sum = 0.0, n = 0.0;  // of those before it in its part
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const Sequence::Value& here = sequence.values[k];
    const double value = here.number.value;
    const std::string place = "line " + std::to_string(here.line) + ": ";
    if (!(value > 0.0))
      throw FileError(name,
                      place + (heights ? "a height of " + short_number(value) + "; heights are above 0: leave it out"
                                       : "an interval of " + short_number(value) +
                                             "; intervals are above 0: leave it out, or say --as times"));
    const NumberCell* before = sequence.before(k);
    sum = before ? sum + before->value : 0.0, n = before ? n + 1.0 : 0.0;
    const bool is_last = k + 1 == sequence.values.size() || !sequence.before(k + 1);
    if (is_last && n >= 3.0 && value > before->value && std::abs(value - sum / n) <= rounding)
      times.mean = place + "the last number is the mean of those before it: was it measured? Else delete the line";
    const bool begins = !before || (!sequence.has_drops && value > grown * before->value);
    if (before && !begins && !sequence.has_drops && value > risen * before->value && times.risen.empty())
      times.risen =
          place + "the ball rose higher than before; a new drop? Write a blank line above it, or a column drop";
    if (begins) times.t_s.push_back(0.0), times.drop.push_back(++drop);
    times.drop_of_value.push_back(drop);
    if (heights) times.fall_m.push_back(si * value);
    if (heights && begins) continue;
    times.t_s.push_back(times.t_s.back() + (heights ? std::sqrt(8.0 * si * value / kDefaultGravity_mps2) : si * value));
    times.drop.push_back(drop);
  }
  return times;
}

/// Heights before and after a bounce: each row is a drop of one.
Sequence numbers_of_pairs(const ForeignTable& table, const std::vector<std::size_t>& columns, const std::string& name) {
  Sequence sequence;
  sequence.unit = unit_of(table, columns, Dimension::length, name);
  sequence.has_drops = true;
  for (const PairOfCells& pair : pairs_in(table, columns[0], columns[1], name))
    for (NumberCell cell : {pair.first, pair.second}) {
      if (cell.value == 0.0)
        throw FileError(name, "line " + std::to_string(pair.row->line) + ": a bounce from or to 0; leave it out");
      cell.value = std::abs(cell.value);
      sequence.values.push_back({cell, pair.row->line, static_cast<std::int64_t>(pair.row->line)});
    }
  return sequence;
}

std::string counted(std::size_t n, const char* what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); }

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
  if (own_column(table, "eps") && own_column(table, "v_mps") && !own_column(table, "t_s") && !options.tells())
    throw FileError(name, "holds speeds and coefficients of restitution, no times; bouncelab fit takes it");
  const auto from = told_column(table, options, "h0", name), to = told_column(table, options, "h", name);
  const bool are_pairs = from && to;
  const Selection selection =
      are_pairs ? Selection{{*from, *to}, Dimension::length, true} : selection_of(table, options, name);
  const Sequence sequence =
      are_pairs ? numbers_of_pairs(table, selection.columns, name) : numbers_of(table, selection, options, name);
  if (sequence.values.empty()) throw FileError(name, "holds no times, intervals or heights");
  constexpr std::size_t kFrames = 8;  // of a video
  if (options.as == "auto" && sequence.values.size() >= kFrames && has_equal_steps(sequence))
    ask(table, name,
        "has times that are equally spaced, as the frames of a video are; impact times are needed: leave "
        "the rows of the impacts only",
        {{"if each is an impact", {"times", options.unit, options.columns}}});
  const std::string as = meaning_of(table, selection, sequence, options, name);
  const TitleUnit unit = unit_of_numbers(table, sequence, as, options, name);
  Times times = as == "times" ? times_of_times(sequence, unit.si, name)
                              : times_of_flights(sequence, unit.si, as == "heights", name);
  if (!are_pairs) check_others(table, selection, sequence, unit, times.drop_of_value, options, name);
  if (!times.risen.empty()) ask(table, name, times.risen, {});
  if (!times.mean.empty() && options.columns.empty())
    ask(table, name, times.mean,
        {{"it was", {as, options.unit, columns_option(table, selection.key(), selection.columns)}}});
  const std::size_t n_impacts = times.t_s.size(), n_drops = static_cast<std::size_t>(times.drop.back()) + 1;
  if (as == "heights" && n_impacts == n_drops)
    throw FileError(name, "one height; two are needed, of the release and of the first bounce");
  double rounding = HUGE_VAL;  // the finest: people drop zeros
  for (const Sequence::Value& value : sequence.values)
    if (value.number.rounding > 0.0) rounding = std::min(rounding, unit.si * value.number.rounding);
  TakenTable taken;
  taken.table.columns.push_back({"drop", std::move(times.drop)});
  taken.table.columns.push_back({"t_s", std::move(times.t_s), as == "heights" ? -1 : decimals_of(rounding)});
  if (as == "heights") taken.table.columns.push_back({"fall_m", std::move(times.fall_m), decimals_of(rounding)});
  if (as == "times" && selection.columns.size() == 1 && n_impacts == table.rows.size()) {
    std::vector<ColumnSpec> own = onset_columns();
    std::erase_if(own, [](const ColumnSpec& spec) { return spec.type == ColumnType::integer; });  // numbered anew
    add_own_columns(table, own, name, taken.table);
  }
  for (std::size_t k = 0; k < n_impacts && as == "times"; ++k) taken.table.stands_on(k, sequence.values[k].line);
  const std::string how =
      are_pairs ? column_name(table, *from) + " and " + column_name(table, *to) : source_in_words(table, selection);
  taken.taken_for =
      as + (as == "heights" ? "" : (unit.name == kClock ? " as " : " in ") + unit.name) +
      (are_pairs ? " before and after" : "") + (how.empty() ? "" : " (" + how + ")") + ": " +
      (as == "heights" ? counted(n_impacts - n_drops, "bounce") : std::to_string(n_impacts) + " impacts") + " in " +
      counted(n_drops, "drop");
  return taken;
}

}  // namespace bouncelab
