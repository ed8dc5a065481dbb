// SPDX-License-Identifier: GPL-3.0-or-later
#include "tables/foreign_sequence.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"

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

}  // namespace

Sequence numbers_of(const ForeignTable& table, const Selection& selection, const ForeignOptions& options,
                    const std::string& name) {
  const std::vector<std::size_t>& columns = selection.columns;
  const bool by_rows = selection.by_rows;
  Sequence sequence;
  sequence.unit = unit_of(table, columns, selection.dimension, name);
  std::optional<std::size_t> drop;
  if (!by_rows) {
    drop = told_column(table, options, "drop", name);
    if (!drop && columns.front() > 0) check_first_cells(table, name);
    if (!drop && std::count(table.titles.begin(), table.titles.end(), "drop") > 1)
      ask(table, name, "several columns are called drop; name one: --columns t=COLUMN,drop=NUMBER", {});
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
        throw FileError(name, "line " + std::to_string(row.line) + ": drop '" + printable(row.cells[*drop], 60) +
                                  "' comes again behind another; put the rows of a drop together");
      begins = true;
      drops.push_back(row.cells[*drop]);
    }
    const bool has_begun = !sequence.values.empty() && sequence.values.back().part == part;
    if (begins && has_begun) ++part, gap.clear();
    auto number = number_in(table, row, column, name);
    if (!number) {
      if (has_begun && !begins && gap.empty()) gap = place_of(table, row, column);
      continue;
    }
    if (const std::string doubt = thousands.doubt(row.cells[column], number->value); !doubt.empty())
      throw FileError(name, place_of(table, row, column) + ": " + doubt);
    if (!gap.empty())
      throw FileError(name, gap + ": the cell is empty, and without it two intervals would be one; write it" +
                                (by_rows ? "" : ", or a blank line in its place, which begins a new drop"));
    if (number->is_clock && !(sequence.unit && sequence.unit->si == 1.0))
      throw FileError(name, place_of(table, row, column) + ": '" + printable(row.cells[column], 60) +
                                "' is a clock time, and others are not");
    if (number->is_clock && has_begun && !begins)
      number->value = behind_midnight(number->value, sequence.values.back().number.value);
    sequence.values.push_back({*number, row.line, part});
  }
  sequence.has_drops = drop || (by_rows ? table.rows.size() : columns.size()) > 1;
  return sequence;
}

std::string source_in_words(const ForeignTable& table, const Selection& selection) {
  const std::size_t n = selection.by_rows ? table.rows.size() : selection.columns.size();
  std::string text = n > 1                  ? std::to_string(n) + (selection.by_rows ? " rows" : " columns")
                     : selection.by_rows    ? "a row"
                     : table.titles.empty() ? ""
                                            : column_name(table, selection.columns.front());
  if (const std::string format = format_in_words(table); !format.empty()) text += (text.empty() ? "" : ", ") + format;
  return text;
}

bool numbers_rows(const ForeignTable& table, std::size_t column) {
  std::optional<double> first;
  for (const ForeignTable::Row& row : table.rows)
    if (const auto number = table.number(row, column)) {
      if (number->value != std::floor(number->value)) return false;
      if (!first) first = number->value;
    }
  return first && (*first == 0.0 || *first == 1.0);
}

bool rises(const Sequence& sequence) {
  if (sequence.values.empty()) return false;
  constexpr std::size_t kLeast = 3;
  std::size_t n = 1;
  for (std::size_t k = 1; k < sequence.values.size(); ++k) {
    const NumberCell* before = sequence.before(k);
    if (before && sequence.values[k].number.value >= before->value) {
      ++n;
      continue;
    }
    if (before && (n < kLeast || sequence.has_drops)) return false;
    n = 1;
  }
  return sequence.has_drops || sequence.values.back().part > 0 || n >= kLeast || n == sequence.values.size();
}

bool goes_one_way(const Sequence& sequence) {
  std::size_t n_up = 0, n_down = 0, n = 0, n_parts = 0;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const NumberCell* before = sequence.before(k);
    ++(before ? n : n_parts);
    n_up += before && sequence.values[k].number.value > before->value ? 1 : 0;
    n_down += before && sequence.values[k].number.value < before->value ? 1 : 0;
  }
  return n > 0 && n >= 2 * n_parts && (n == n_up || n == n_down);
}

bool has_equal_steps(const Sequence& sequence) {
  const auto& values = sequence.values;
  if (values.size() < 3) return false;
  const double step = values[1].number.value - values[0].number.value;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (std::abs(values[k].number.value - values[k - 1].number.value - step) >
        0.1 * step + 2.0 * (values[k - 1].number.rounding + values[k].number.rounding))
      return false;
  return step > 0.0;
}

namespace {

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
void check_units(const ForeignTable& table, std::size_t column, const TitleUnit& unit, const std::string& name) {
  const ForeignTable::Row* other = nullptr;
  for (const ForeignTable::Row& row : table.rows) {
    const auto known = unit_of_title("x (" + row.cells[column] + ")");
    if (!known || known->dimension != unit.dimension) return;  // "in", and out
    if (known->si != unit.si) other = &row;
  }
  if (other)
    throw FileError(name, place_of(table, *other, column) + ": '" + other->cells[column] + "' beside a number in " +
                              unit.name + "; write all numbers in one unit, and this unit in their title: Time (" +
                              other->cells[column] + ")");
}

}  // namespace

void check_others(const ForeignTable& table, const Selection& selection, const Sequence& sequence,
                  const TitleUnit& unit, const std::vector<std::int64_t>& drop_of_value, const ForeignOptions& options,
                  const std::string& name) {
  const auto& values = sequence.values;
  const ForeignOptions as_it_is{options.as, options.unit, columns_option(table, selection.key(), selection.columns)};
  if (selection.by_rows || selection.columns.size() > 1 || !options.columns.empty()) return;
  const std::vector<ColumnSpec> own = onset_columns();
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const std::string title = title_of(table, k);
    if (k == selection.columns.front() || unit_of(table, k) ||
        std::any_of(own.begin(), own.end(), [&](const ColumnSpec& spec) { return spec.name == title; }))
      continue;
    if (options.unit == "auto") check_units(table, k, unit, name);
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
      ask(table, name,
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
    ask(table, name, column_name(table, k) + " changes where no new drop is seen; does it tell the drops?",
        std::move(readings));
  }
}

}  // namespace bouncelab
