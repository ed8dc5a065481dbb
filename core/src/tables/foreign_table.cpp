// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/foreign_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kMostColumns = 1024;
constexpr std::size_t kLinesToDecide = 200;
// in the order of preference: a comma or a blank stands in many cells that it does not separate
constexpr std::array<CellFormat, 8> kFormats{
    {{'\t', '.'}, {'\t', ','}, {';', '.'}, {';', ','}, {',', '.'}, {',', ','}, {' ', '.'}, {' ', ','}}};

struct Line {
  std::size_t number = 0;
  std::string_view text;
};

/// Lines that are not blank, no comments (#) and no frequencies of Audacity's labels (\).
std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const bool is_blank = line.find_first_not_of(" \t\r,;") == std::string_view::npos;
    if (!is_blank && line.front() != '#' && line.front() != '\\') lines.push_back({number, line});
  }
  return lines;
}

/// Of the rows with a number those of the commonest length, and their numbers.
struct Fit {
  std::size_t n_rows = 0, n_numbers = 0, n_cells = 0;
  std::vector<std::size_t> n_in_column{};

  /// Numbers in columns that have one in every row.
  std::size_t n_in_whole_columns() const {
    return n_rows * static_cast<std::size_t>(std::count(n_in_column.begin(), n_in_column.end(), n_rows));
  }
};

Fit fit_of(const CellFormat& format, const std::vector<Line>& lines) {
  std::map<std::size_t, Fit> by_length;
  for (const Line& line : lines) {
    const std::vector<std::string_view> cells = cells_of(line.text, format.separator);
    if (cells.size() == 1 && format.separator != ' ') continue;
    std::vector<std::size_t> numbers;
    for (const std::string_view cell : cells) numbers.push_back(number_of(cell, format.decimal) ? 1 : 0);
    const auto n = static_cast<std::size_t>(std::count(numbers.begin(), numbers.end(), 1U));
    if (n == 0) continue;
    Fit& fit = by_length[cells.size()];
    fit.n_rows += 1, fit.n_numbers += n, fit.n_cells = cells.size();
    fit.n_in_column.resize(cells.size());
    for (std::size_t k = 0; k < numbers.size(); ++k) fit.n_in_column[k] += numbers[k];
  }
  Fit best;
  for (const auto& [length, fit] : by_length)
    if (fit.n_rows > best.n_rows) best = fit;
  return best;
}

/// "0,400000" in each line, where the whole numbers in front do not count 1, 2, 3, or "00:00:00,400": a decimal comma.
bool is_decimal_comma(const std::vector<Line>& lines) {
  double before = 0.0;
  bool counts = true;
  std::size_t n = 0, n_digits = 0;
  for (const Line& line : lines) {
    const std::vector<std::string_view> cells = cells_of(line.text, ',');
    const auto first = number_of(cells[0], '.');
    const bool is_clock = cells.size() == 2 && first && first->is_clock &&
                          cells[1].find_first_not_of("0123456789") == std::string_view::npos;
    if (!is_clock && !is_ambiguous(line.text, {',', '.'})) continue;  // a title
    counts = counts && !is_clock;
    const double here = first->value;
    if (n++ == 0) n_digits = cells[1].size();
    if (cells[1].size() != n_digits) return false;
    counts = counts && (n == 1 || here == before + 1.0);
    before = here;
  }
  return n > 1 && !counts;
}

CellFormat format_of_lines(std::vector<Line> lines, const std::string& name) {
  if (lines.size() > kLinesToDecide) lines.resize(kLinesToDecide);
  std::array<Fit, kFormats.size()> fits;
  std::size_t most = 0;
  for (std::size_t k = 0; k < kFormats.size(); ++k) {
    fits[k] = fit_of(kFormats[k], lines);
    most = std::max(most, fits[k].n_rows);
  }
  if (most == 0)
    throw FileError(name, "line " + std::to_string(lines.front().number) + ": " + printable(lines.front().text, 60) +
                              ": no line holds numbers; a table of times or intervals, or marks are needed");
  // nine tenths: a remark between the rows may have a number of its own
  const auto holds = [&](std::size_t k) { return 10 * fits[k].n_rows >= 9 * most; };
  for (std::size_t k = 0; k < kFormats.size(); k += 2) {
    if (!holds(k) && !holds(k + 1)) continue;
    // the first column, then whole columns: texts beside them may hold numbers that are written otherwise
    const auto score = [&](std::size_t f) {
      const Fit& fit = fits[f];
      return std::tuple(fit.n_rows > 0 ? fit.n_in_column.front() : 0, fit.n_in_whole_columns(), fit.n_numbers);
    };
    const bool comma = !holds(k) || (holds(k + 1) && score(k + 1) > score(k));
    const CellFormat format = kFormats[comma ? k + 1 : k];
    if (format.separator != ',' || comma) return format;
    if (is_decimal_comma(lines)) return {' ', ','};
    const bool named = !is_ambiguous(lines.front().text, format) && lines.front().text.find(',') != std::string::npos;
    for (const Line& line : lines)
      if (is_ambiguous(line.text, format) && !named)
        throw FileError(name, "line " + std::to_string(line.number) + ": " + printable(line.text) +
                                  " is one number or two; write a decimal point, or separate by ;");
    return format;
  }
  return {};
}

ForeignTable::Row row_of(const Line& line, const CellFormat& format) {
  const std::vector<std::string_view> cells = cells_of(line.text, format.separator);
  return {line.number, format.decimal, {cells.begin(), cells.end()}};
}

/// ",1,2,3,4" or "Drop,1,2,3" above rows of numbers.
void take_numbers_for_titles(ForeignTable& table) {
  if (!table.titles.empty() || table.rows.size() < 2) return;
  double n = 0.0;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const auto number = table.rows.front().number(k);
    if (number ? number->value != n + 1.0 : n > 0.0) return;
    n += number ? 1.0 : 0.0;
  }
  if (n < 3.0) return;
  table.titles = std::move(table.rows.front().cells);
  table.rows.erase(table.rows.begin());
}

}  // namespace

ForeignTable read_foreign_table(std::string_view text, const std::string& name) {
  const std::vector<Line> lines = lines_of(text);
  if (lines.empty()) throw FileError(name, "is empty; a table of times or intervals, or marks are needed");
  ForeignTable table;
  table.format = format_of_lines(lines, name);
  const std::size_t n_cells = fit_of(table.format, lines).n_cells;
  if (n_cells > kMostColumns)
    throw FileError(
        name, "has " + std::to_string(n_cells) + " columns; at most " + std::to_string(kMostColumns) + " are read");
  table.rows.reserve(lines.size());
  for (const Line& line : lines) {
    ForeignTable::Row row = row_of(line, table.format);
    const bool has_number = std::any_of(row.cells.begin(), row.cells.end(), [&](const std::string& cell) {
      return number_of(cell, table.format.decimal).has_value();
    });
    // once the rows have begun, one without a number is among them too: who takes its column refuses it
    const bool has_cells = row.cells.size() == n_cells;
    const bool is_row = table.rows.empty() ? has_number && has_cells : has_number || has_cells;
    if (!is_row && table.rows.empty()) {
      table.titles.clear();
      if (n_cells == 1)  // with its blanks: "Time (s)"
        table.titles.emplace_back(cells_of(line.text, '\0').front());
      else if (row.cells.size() == n_cells)
        table.titles = std::move(row.cells);
      continue;
    }
    if (!is_row) {
      if (table.n_left_out++ == 0) table.first_left_out = line.number;
      continue;
    }
    row.cells.resize(std::max(row.cells.size(), n_cells));
    table.rows.push_back(std::move(row));
  }
  take_numbers_for_titles(table);
  return table;
}

std::optional<double> uniform_step_s(const ForeignTable& table) {
  constexpr std::size_t kLeastRows = 8;
  if (table.n_columns() < 2 || table.rows.size() < kLeastRows) return std::nullopt;
  // the first column of numbers that does not count the rows
  for (std::size_t column = 0; column < table.n_columns(); ++column) {
    std::vector<NumberCell> times;
    for (const ForeignTable::Row& row : table.rows)
      if (const auto number = row.number(column)) times.push_back(*number);
    if (times.size() < table.rows.size()) continue;
    const double step = times[1].value - times[0].value;
    if (!(step > 0.0)) return std::nullopt;
    bool uniform = true;
    for (std::size_t k = 1; k < times.size() && uniform; ++k)
      uniform = std::abs(times[k].value - times[k - 1].value - step) <=
                0.1 * step + 2.0 * (times[k - 1].rounding + times[k].rounding);
    if (!uniform) return std::nullopt;
    const std::string title = column < table.titles.size() ? table.titles[column] : std::string();
    if (step != 1.0) return step * time_unit_s(title).value_or(1.0);
  }
  return std::nullopt;
}

}  // namespace bouncelab
