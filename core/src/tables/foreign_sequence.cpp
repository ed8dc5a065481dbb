// SPDX-License-Identifier: GPL-3.0-or-later
#include "tables/foreign_sequence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {

/// The unit of a column by its cells, else by its title.
std::optional<TitleUnit> unit_of(const ForeignTable& table, std::size_t column) {
  constexpr double kFrom_s = 978307200.0, kTo_s = 4102444800.0;  // the years 2001 to 2099, since 1970
  constexpr std::array<std::pair<double, const char*>, 4> kSince1970{
      {{1.0, "s since 1970"}, {1e-3, "ms since 1970"}, {1e-6, "us since 1970"}, {1e-9, "ns since 1970"}}};
  std::size_t n = 0, n_clocks = 0;
  double least = HUGE_VAL, most = 0.0;
  for (const ForeignTable::Row& row : table.rows)
    if (const auto number = table.number(row, column)) {
      ++n, n_clocks += number->is_clock ? 1 : 0;
      least = std::min(least, number->value), most = std::max(most, number->value);
    }
  if (n > 0 && n_clocks == n) return TitleUnit{Dimension::time, 1.0, kClock, {}};
  if (auto titled = unit_of_title(title_of(table, column))) return titled;
  for (const auto& [unit_s, words] : kSince1970)
    if (n > 0 && unit_s * least > kFrom_s && unit_s * most < kTo_s)
      return TitleUnit{Dimension::time, unit_s, words, {}};
  return std::nullopt;
}

ForeignOptions told(std::string as, std::string unit, std::string columns) {
  return {std::move(as), std::move(unit), std::move(columns)};
}

std::vector<double> Sequence::roundings() const {
  std::vector<double> all;
  for (const Value& value : values) all.push_back(value.number.rounding);
  return all;
}

std::string source_in_words(const ForeignTable& table, const Sequence& sequence) {
  std::string text = !sequence.column ? "a row" : table.titles.empty() ? "" : column_name(table, *sequence.column);
  if (const std::string format = format_in_words(table); !format.empty()) text += (text.empty() ? "" : ", ") + format;
  return text;
}

Sequence row_of_numbers(const ForeignTable& table, const std::string& name) {
  Sequence sequence;
  const ForeignTable::Row& row = table.rows.front();
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const auto number = number_in(table, row, k, name);
    if (number && sequence.values.size() < k)
      throw FileError(name, "line " + std::to_string(row.line) + ", " + column_name(table, sequence.values.size()) +
                                ": the cell is empty, and without it two intervals would be one");
    if (number) sequence.values.push_back({*number, row.line, 0});
  }
  sequence.unit = unit_of(table, 0);
  return sequence;
}

Sequence column_of_numbers(const ForeignTable& table, std::size_t column, const ForeignOptions& options,
                           const std::string& name) {
  Sequence sequence;
  sequence.column = column;
  sequence.unit = unit_of(table, column);
  auto drop = told_column(table, options, "drop", name);
  if (!drop && column > 0) check_first_cells(table, name);
  if (!drop && std::count(table.titles.begin(), table.titles.end(), "drop") > 1)
    ask(table, name, "several columns are called drop; name one: --columns t=COLUMN,drop=NUMBER", {});
  if (!drop) drop = own_column(table, "drop");
  std::int64_t part = 0;
  std::vector<std::string> drops;
  const ForeignTable::Row *whole = nullptr, *parted = nullptr;  // 867, and 1,412
  std::optional<std::size_t> gap;  // the line of an empty cell behind a number of this part
  for (const ForeignTable::Row& row : table.rows) {
    bool begins = !drop && row.follows_blank;
    if (drop && !row.cells[*drop].empty() && (drops.empty() || drops.back() != row.cells[*drop])) {
      if (std::find(drops.begin(), drops.end(), row.cells[*drop]) != drops.end())
        throw FileError(name, "line " + std::to_string(row.line) + ": drop '" + printable(row.cells[*drop], 60) +
                                  "' comes again behind another; put the rows of a drop together");
      begins = !drops.empty();
      drops.push_back(row.cells[*drop]);
    }
    if (begins && !sequence.values.empty()) ++part, gap.reset();
    const auto number = number_in(table, row, column, name);
    if (!number) {
      if (!sequence.values.empty() && sequence.values.back().part == part && !gap) gap = row.line;
      continue;
    }
    const std::string& cell = row.cells[column];
    const std::size_t sign = cell.find_first_not_of("0123456789");
    if (sign == std::string::npos && number->value >= 100.0) whole = &row;
    if (sign != std::string::npos && sign > 0 && cell.front() != '0' && (cell[sign] == '.' || cell[sign] == ',') &&
        cell.size() == sign + 4 && cell.find_first_not_of("0123456789", sign + 1) == std::string::npos)
      parted = &row;
    if (whole && parted)
      throw FileError(name, "line " + std::to_string(parted->line) + ", " + column_name(table, column) + ": '" +
                                printable(parted->cells[column], 60) + "' beside '" +
                                printable(whole->cells[column], 60) +
                                "': does the sign part thousands? Write numbers without it");
    if (gap)
      throw FileError(name, "line " + std::to_string(*gap) + ", " + column_name(table, column) +
                                ": the cell is empty, and without it two intervals would be one; write it, or a blank "
                                "line in its place, which begins a new drop");
    if (number->is_clock && !(sequence.unit && sequence.unit->si == 1.0))
      throw FileError(name, "line " + std::to_string(row.line) + ", " + column_name(table, column) + ": '" +
                                printable(row.cells[column], 60) + "' is a clock time, and others are not");
    sequence.values.push_back({*number, row.line, part});
  }
  sequence.has_drops = drop.has_value();
  return sequence;
}

namespace {

/// 0, 1, 2 or 1, 2, 3, and so again.
bool counts_in_each_drop(const ForeignTable& table, std::size_t column) {
  double before = -1.0;
  for (const ForeignTable::Row& row : table.rows) {
    const auto number = table.number(row, column);
    if (!number || (number->value != before + 1.0 && (number->value == before || number->value > 1.0))) return false;
    before = number->value;
  }
  return true;
}

}  // namespace

void check_blocks(const ForeignTable& table, std::size_t column, std::string_view key,
                  const std::vector<std::int64_t>& drop_of_row, const ForeignOptions& options,
                  const std::string& name) {
  const std::vector<ColumnSpec> own = onset_columns();
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const std::string title = title_of(table, k);
    if (k == column || unit_of(table, k) ||
        std::any_of(own.begin(), own.end(), [&](const ColumnSpec& spec) { return spec.name == title; }))
      continue;
    std::vector<std::string> blocks;
    bool same = true, are_words = true;
    const bool counts = counts_in_each_drop(table, k);
    std::int64_t of_block = -1;
    double before = -1.0;
    std::size_t shortest = table.rows.size(), n_in_block = 0;
    std::map<std::string, std::size_t> n_of;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const std::string& cell = table.rows[row].cells[k];
      const auto number = table.number(table.rows[row], k);
      are_words = are_words && !cell.empty() && !number;
      ++n_of[cell];
      const bool goes_on =
          !blocks.empty() && (counts ? number->value == before + 1.0 : cell.empty() || cell == blocks.back());
      if (!goes_on) {
        if (!blocks.empty()) shortest = std::min(shortest, n_in_block);
        blocks.push_back(cell), of_block = -1, n_in_block = 0;
      }
      if (number) before = number->value;
      ++n_in_block;
      if (drop_of_row[row] < 0) continue;
      same = same && (of_block < 0 || of_block == drop_of_row[row]);
      of_block = drop_of_row[row];
    }
    std::vector<std::string> sorted = blocks;
    std::sort(sorted.begin(), sorted.end());
    const bool comes_again = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    const bool are_blocks = std::min(shortest, n_in_block) > 1 && blocks.size() > 1 && (!comes_again || counts);
    // two balls in turn, or rows that are no impacts: few words of which each stands in several rows
    if (are_words && n_of.size() > 1 && 2 * n_of.size() <= table.rows.size() && comes_again)
      ask(table, name,
          column_name(table, k) +
              " has the same words in several rows that do not follow each other; is each row an impact of one ball?",
          {{"they are", told(options.as, options.unit, column_option(table, key, column))}});
    const auto n_drops = static_cast<std::size_t>(*std::max_element(drop_of_row.begin(), drop_of_row.end()) + 1);
    if (!are_blocks || (same && n_drops == blocks.size())) continue;
    const std::string t = column_option(table, key, column);
    ask(table, name, column_name(table, k) + " changes where no new drop is seen; does it tell the drops?",
        counts ? std::vector<Reading>{{"it does not", told(options.as, options.unit, t)}}
               : std::vector<Reading>{
                     {"it does", told(options.as, options.unit, t + "," + column_option(table, "drop", k))},
                     {"it does not", told(options.as, options.unit, t)}});
  }
}

}  // namespace bouncelab
