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
#include <set>
#include <span>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"

namespace bouncelab {
namespace {

/// "867" beside "1,412": does the sign part thousands?
class Thousands {
 public:
  /// What is said of them; empty as long as there are not both.
  std::string doubt(const std::string& cell, double value) {
    const std::size_t sign = cell.find_first_not_of("0123456789");
    if (sign == std::string::npos && value >= 100.0) whole_ = cell;
    if (sign != std::string::npos && sign > 0 && cell.front() != '0' && (cell[sign] == '.' || cell[sign] == ',') &&
        cell.size() == sign + 4 && cell.find_first_not_of("0123456789", sign + 1) == std::string::npos)
      parted_ = cell;
    if (whole_.empty() || parted_.empty()) return {};
    return "'" + printable(parted_, 60) + "' beside '" + printable(whole_, 60) +
           "': does the sign part thousands? Write numbers without it";
  }

 private:
  std::string whole_, parted_;
};

/// Over midnight the hours of a clock begin again.
double behind_midnight(double clock_s, double before_s) {
  constexpr double kDay_s = 86400.0;
  const double back_s = before_s - clock_s;
  return before_s < 2.0 * kDay_s && back_s > kDay_s - kLongestFlight_s && back_s < kDay_s ? clock_s + kDay_s : clock_s;
}

/// With the drops by --columns drop=..., a column called drop, or blank lines. @throws FileError, AmbiguousTable
Sequence numbers_of(const ForeignTable& table, const Selection& selection) {
  const std::vector<std::size_t>& columns = selection.columns;
  const bool by_rows = selection.by_rows;
  Sequence sequence;
  sequence.unit = unit_of(table, columns, selection.dimension);
  std::optional<std::size_t> drop;
  if (!by_rows) {
    drop = told_column(table, "drop");
    if (!drop && columns.front() > 0) check_first_cells(table);
    if (!drop && std::count(table.titles.begin(), table.titles.end(), "drop") > 1)
      ask(table, "several columns are called drop; name one (--columns t=COLUMN,drop=NUMBER)", {});
    if (!drop) drop = own_column(table, "drop");
  }
  const std::size_t length = by_rows ? columns.size() : table.rows.size();
  std::int64_t part = 0;
  std::vector<std::string> drops;
  std::string gap;  // the place of an empty cell behind a number of this part
  Thousands thousands;
  for (std::size_t k = 0; k < table.rows.size() * columns.size(); ++k) {
    const ForeignTable::Row& row = table.rows[by_rows ? k / length : k % length];
    const std::size_t column = columns[by_rows ? k % length : k / length];
    bool begins = k % length == 0 || (!drop && !by_rows && row.follows_blank);
    if (k % length == 0) drops.clear();
    if (drop && !row.cells[*drop].empty() && (drops.empty() || drops.back() != row.cells[*drop])) {
      if (std::find(drops.begin(), drops.end(), row.cells[*drop]) != drops.end())
        table.refuse("line " + std::to_string(row.line) + ": drop '" + printable(row.cells[*drop], 60) +
                     "' comes again behind another; put the rows of a drop together");
      begins = true;
      drops.push_back(row.cells[*drop]);
    }
    const bool has_begun = !sequence.values.empty() && sequence.values.back().part == part;
    if (begins && has_begun) ++part, gap.clear();
    auto number = number_in(table, row, column);
    if (!number) {
      if (has_begun && !begins && gap.empty()) gap = place_of(table, row, column);
      continue;
    }
    if (const std::string doubt = thousands.doubt(row.cells[column], number->value); !doubt.empty())
      table.refuse(place_of(table, row, column) + ": " + doubt);
    if (!gap.empty())
      table.refuse(gap + ": the cell is empty, and without it two intervals would be one; write it" +
                   (by_rows ? "" : ", or a blank line in its place, which begins a new drop"));
    if (number->is_clock && !(sequence.unit && sequence.unit->si == 1.0))
      table.refuse(place_of(table, row, column) + ": '" + printable(row.cells[column], 60) +
                   "' is a clock time, and others are not");
    if (number->is_clock && has_begun && !begins)
      number->value = behind_midnight(number->value, sequence.values.back().number.value);
    sequence.values.push_back({*number, row.line, part});
  }
  sequence.has_drops = drop || (by_rows ? table.rows.size() : columns.size()) > 1;
  return sequence;
}

/// "column 'Time (s)', ';' between, decimal comma"
std::string source_in_words(const ForeignTable& table, const Selection& selection) {
  const std::size_t n = selection.by_rows ? table.rows.size() : selection.columns.size();
  std::string text = n > 1                  ? std::to_string(n) + (selection.by_rows ? " rows" : " columns")
                     : selection.by_rows    ? "a row"
                     : table.titles.empty() ? ""
                                            : column_name(table, selection.columns.front());
  if (const std::string format = format_in_words(table); !format.empty()) text += (text.empty() ? "" : ", ") + format;
  return text;
}

/// What a column says of the rows: each block is of rows that belong together.
struct Marks {
  std::vector<std::size_t> block_of_row;
  std::string word;  ///< in some rows, not in all
  bool counts = true, comes_again = false, are_few = false;
};

Marks marks_of(const ForeignTable& table, std::size_t column) {
  Marks marks;
  std::set<std::string> different;
  std::size_t n_words = 0;
  const std::string* before = nullptr;
  double count = -1.0;  // 0, 1, 2 or 1, 2, 3, and so again
  for (const ForeignTable::Row& row : table.rows) {
    const auto number = table.number(row, column);
    marks.counts = marks.counts && number && number->value != count &&
                   (number->value == count + 1.0 || number->value == 0.0 || number->value == 1.0);
    if (number) count = number->value;
    if (!number && !row.cells[column].empty() && n_words++ == 0) marks.word = row.cells[column];
  }
  count = -1.0;
  for (const ForeignTable::Row& row : table.rows) {
    // a merged cell stands in its first row only
    const std::string& cell = row.cells[column].empty() && before ? *before : row.cells[column];
    const bool goes_on = marks.counts ? table.number(row, column)->value == count + 1.0 : before && cell == *before;
    if (marks.counts) count = table.number(row, column)->value;
    const std::size_t last = marks.block_of_row.empty() ? 0 : marks.block_of_row.back();
    marks.block_of_row.push_back(last + (before && !goes_on ? 1 : 0));
    if (before && !goes_on) marks.comes_again = marks.comes_again || different.contains(cell);
    different.insert(cell);
    before = &cell;
  }
  if (n_words == table.rows.size()) marks.word.clear();
  marks.are_few = different.size() > 1 && 2 * different.size() <= table.rows.size();
  return marks;
}

/// A column of units, "ms" in each row, that are not the one in which the numbers are read.
void check_units(const ForeignTable& table, std::size_t column, const TitleUnit& unit) {
  const ForeignTable::Row* other = nullptr;
  for (const ForeignTable::Row& row : table.rows) {
    const auto known = unit_of_title("x (" + row.cells[column] + ")");
    if (!known || known->dimension != unit.dimension) return;  // "in", and out
    if (known->si != unit.si) other = &row;
  }
  if (other)
    table.refuse(place_of(table, *other, column) + ": '" + other->cells[column] + "' beside a number in " + unit.name +
                 "; write all numbers in one unit, and this unit in their title: Time (" + other->cells[column] + ")");
}

/// Asks about columns that may tell more than is read: blocks ("1 1 1 2 2 2") that are not the drops found, words in
/// some rows. @throws FileError: a column names another unit
/// @param drop_of_value  of each number of the sequence
void check_others(const ForeignTable& table, const Selection& selection, const Sequence& sequence,
                  const TitleUnit& unit, const std::vector<std::int64_t>& drop_of_value) {
  const auto& values = sequence.values;
  const ForeignOptions as_it_is{table.options.as, table.options.unit,
                                columns_option(table, selection.key(), selection.columns)};
  if (selection.by_rows || selection.columns.size() > 1 || !table.options.columns.empty()) return;
  const std::vector<ColumnSpec> own = onset_columns();
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const std::string title = title_of(table, k);
    if (k == selection.columns.front() || unit_of(table, k) ||
        std::any_of(own.begin(), own.end(), [&](const ColumnSpec& spec) { return spec.name == title; }))
      continue;
    if (table.options.unit == "auto") check_units(table, k, unit);
    const Marks marks = marks_of(table, k);
    std::vector<std::int64_t> drop_of_block(marks.block_of_row.back() + 1, -1);
    bool same = static_cast<std::int64_t>(drop_of_block.size()) == drop_of_value.back() + 1;
    for (std::size_t row = 0, value = 0; row < table.rows.size(); ++row) {
      if (value == values.size() || values[value].line != table.rows[row].line) continue;  // no impact
      std::int64_t& of_block = drop_of_block[marks.block_of_row[row]];
      same = same && (of_block < 0 || of_block == drop_of_value[value]);
      of_block = drop_of_value[value++];
    }
    const bool may_tell = marks.counts ? drop_of_block.size() > 1 : marks.are_few || !marks.word.empty();
    if (same || !may_tell) continue;
    const bool may_be_drops = !marks.counts && !marks.comes_again && marks.are_few && !sequence.has_drops;
    if (!marks.counts && !may_be_drops)
      ask(table,
          column_name(table, k) + " tells some rows from others" +
              (marks.word.empty() ? "" : ": '" + printable(marks.word, 60) + "'") +
              "; is each row an impact of one ball? Else delete the others, or write a table of each ball",
          {{"it is", as_it_is}});
    std::vector<AmbiguousTable::Reading> readings{{"it does not", as_it_is}};
    if (may_be_drops) {
      ForeignOptions drops = as_it_is;
      drops.columns += "," + column_option(table, "drop", k);
      readings.insert(readings.begin(), {"it does", drops});
    }
    ask(table, column_name(table, k) + " changes where no new drop is seen; does it tell the drops?",
        std::move(readings));
  }
}

/// What the numbers are: --as, or what they prove.
std::string meaning_of(const ForeignTable& table, const Selection& selection, const Sequence& sequence) {
  if (selection.dimension == Dimension::length) return "heights";
  if (table.options.as != "auto") return table.options.as;
  constexpr std::array<std::string_view, 5> kIntervals{"dt", "\xCE\x94t", "\xE2\x88\x86t", "interval", "Interval"};
  const bool times = rises(sequence), titled = sequence.unit && std::find(kIntervals.begin(), kIntervals.end(),
                                                                          sequence.unit->quantity) != kIntervals.end();
  if (titled != times) return titled ? "intervals" : "times";
  std::vector<const char*> as{"intervals", "times"};
  if (!titled && !sequence.unit) as.push_back("heights");
  std::vector<Reading> readings =
      readings_of(sequence, as, sequence.unit.has_value(), table.options, table.options.columns);
  for (Reading& reading : readings)
    if (reading.options.as == "heights" && !table.titles.empty())
      reading.options.columns = columns_option(table, "h", selection.columns);
  ask(table,
      (selection.by_rows || selection.columns.size() > 1
           ? "the numbers"
           : "the numbers of " + column_name(table, selection.columns[0])) +
          (titled ? " rise, as times do, and their title says intervals"
                  : " do not rise from row to row, as times do: intervals?"),
      std::move(readings));
}

TitleUnit unit_of_numbers(const ForeignTable& table, const Sequence& sequence, const std::string& as) {
  const Dimension dimension = as == "heights" ? Dimension::length : Dimension::time;
  const bool is_clock = sequence.unit && sequence.unit->name == kClock, is_told = table.options.unit != "auto";
  TitleUnit unit = sequence.unit.value_or(TitleUnit{Dimension::time, 1.0, "s", {}});
  if (is_told && !is_clock) unit = unit_called(table.options.unit);
  if (is_told && unit.dimension != dimension)
    throw InvalidArgument("--unit " + table.options.unit + ": " + as + " are in " +
                          (as == "heights" ? "m, cm, mm, in or ft" : "s, ms or us"));
  if (is_told || (as == "heights" && sequence.unit)) return unit;
  const bool is_single = as != "heights" && typical_interval(sequence, as == "intervals") == 0.0;
  if (as != "heights" && (is_single || are_of_a_ball(sequence, as, unit.si))) return unit;
  std::vector<Reading> readings = readings_of(sequence, {as.c_str()}, is_clock, table.options, table.options.columns);
  for (Reading& reading : readings) {
    reading.options.as = as == "heights" ? as : table.options.as;
    if (is_clock) reading.options.unit = "s";
  }
  ask(table,
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

Times times_of_times(const ForeignTable& table, const Sequence& sequence, double unit_s) {
  Times times;
  std::vector<double> of_part;
  std::int64_t next = 0;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const Sequence::Value& here = sequence.values[k];
    if (const NumberCell* before = sequence.before(k); before && here.number.value == before->value)
      table.refuse("line " + std::to_string(here.line) +
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
Times times_of_flights(const ForeignTable& table, const Sequence& sequence, double si, bool heights) {
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
      table.refuse(place + (heights ? "a height of " + short_number(value) + "; heights are above 0: leave it out"
                                    : "an interval of " + short_number(value) +
                                          "; intervals are above 0: leave it out, or are they times (--as times)?"));
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
Sequence numbers_of_pairs(const ForeignTable& table, const std::vector<std::size_t>& columns) {
  Sequence sequence;
  sequence.unit = unit_of(table, columns, Dimension::length);
  sequence.has_drops = true;
  for (const PairOfCells& pair : pairs_in(table, columns[0], columns[1]))
    for (NumberCell cell : {pair.first, pair.second}) {
      if (cell.value == 0.0)
        table.refuse("line " + std::to_string(pair.row->line) + ": a bounce from or to 0; leave it out");
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

TakenTable onsets_from_foreign(const ForeignTable& table) {
  if (table.options.tells_speeds() ||
      (own_column(table, "eps") && own_column(table, "v_mps") && !own_column(table, "t_s") && !table.options.tells()))
    table.refuse("holds speeds and coefficients of restitution, no times (bouncelab fit takes it)");
  const auto from = told_column(table, "h0"), to = from ? told_column(table, "h") : std::nullopt;
  const bool are_pairs = from && to;
  const Selection selection = are_pairs ? Selection{{*from, *to}, Dimension::length, true} : selection_of(table);
  const Sequence sequence = are_pairs ? numbers_of_pairs(table, selection.columns) : numbers_of(table, selection);
  if (sequence.values.empty()) table.refuse("holds no times, intervals or heights");
  const bool has_steps = has_equal_steps(sequence);
  if (table.options.as == "auto" && !are_pairs && sequence.values.size() >= kFrames &&
      (has_steps || (selection.dimension == Dimension::length && goes_up_and_down(sequence))))
    ask_about_path(
        table, selection.columns.front(), has_steps,
        {{"if each is an impact", {has_steps ? "times" : "heights", table.options.unit, table.options.columns}}});
  const std::string as = meaning_of(table, selection, sequence);
  const TitleUnit unit = unit_of_numbers(table, sequence, as);
  Times times = as == "times" ? times_of_times(table, sequence, unit.si)
                              : times_of_flights(table, sequence, unit.si, as == "heights");
  if (!are_pairs) check_others(table, selection, sequence, unit, times.drop_of_value);
  if (!times.risen.empty()) ask(table, times.risen, {});
  if (!times.mean.empty() && table.options.columns.empty())
    ask(table, times.mean,
        {{"it was", {as, table.options.unit, columns_option(table, selection.key(), selection.columns)}}});
  const std::size_t n_impacts = times.t_s.size(), n_drops = static_cast<std::size_t>(times.drop.back()) + 1;
  if (as == "heights" && n_impacts == n_drops)
    table.refuse("one height; two are needed, of the release and of the first bounce");
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
    add_own_columns(table, own, taken.table);
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
