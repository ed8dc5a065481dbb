// SPDX-License-Identifier: GPL-3.0-or-later
#include "tables/foreign_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {

AmbiguousTable::AmbiguousTable(const std::string& file, const std::string& question, std::vector<Column> columns,
                               std::vector<Reading> readings)
    : InvalidArgument([&] {
        std::string text = printable(file) + ": " + question;
        for (std::size_t k = 0; k < readings.size(); ++k)
          text +=
              (k == 0 ? "; say " : " or ") + command_line_of(readings[k].options) + " (" + readings[k].meaning + ")";
        return text;
      }()),
      question_(printable(file) + ": " + question),
      columns_(std::move(columns)),
      readings_(std::move(readings)) {}

std::string command_line_of(const ForeignOptions& options) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value) {
    if (value != "auto" && !value.empty())
      text += (text.empty() ? "--" : " --") + std::string(name) + " " + shell_word(value);
  };
  add("as", options.as), add("unit", options.unit), add("columns", options.columns);
  return text;
}

std::string title_of(const ForeignTable& table, std::size_t column) {
  return column < table.titles.size() ? table.titles[column] : std::string();
}

/// Names a title one column?
static bool is_alone(const ForeignTable& table, const std::string& title) {
  return !title.empty() && std::count(table.titles.begin(), table.titles.end(), title) == 1;
}

std::string column_name(const ForeignTable& table, std::size_t column) {
  const std::string title = title_of(table, column);
  return is_alone(table, title) ? "column '" + printable(title, 60) + "'" : "column " + std::to_string(column + 1);
}

std::string format_in_words(const ForeignTable& table) {
  std::string text;
  if (table.n_columns() > 1)
    text = table.format.separator == '\t'  ? "tabs between"
           : table.format.separator == ' ' ? "blanks between"
                                           : std::string("'") + table.format.separator + "' between";
  if (table.format.decimal == ',') text += (text.empty() ? "" : ", ") + std::string("decimal comma");
  return text;
}

std::optional<std::size_t> own_column(const ForeignTable& table, std::string_view title) {
  const auto found = std::find(table.titles.begin(), table.titles.end(), title);
  if (found == table.titles.end() || !is_alone(table, *found)) return std::nullopt;
  return static_cast<std::size_t>(found - table.titles.begin());
}

std::optional<std::size_t> told_column(const ForeignTable& table, const ForeignOptions& options, std::string_view key,
                                       const std::string& name) {
  for (const std::string_view part : cells_of(options.columns, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos && !part.empty())
      throw InvalidArgument("--columns: '" + printable(part) + "' is no KEY=COLUMN, such as v=speed,eps=e");
    if (part.substr(0, equals) != key) continue;
    const std::string_view wanted = part.substr(equals + 1);
    if (const auto titled = own_column(table, wanted)) return titled;
    const auto number = number_of(wanted, '.');
    if (number && number->value >= 1.0 && number->value <= static_cast<double>(table.n_columns()) &&
        number->value == std::floor(number->value))
      return static_cast<std::size_t>(number->value) - 1;
    std::string found;
    for (std::size_t k = 0; k < table.n_columns(); ++k) found += (k == 0 ? "" : ", ") + column_name(table, k);
    throw FileError(name, "has no column '" + printable(wanted) + "' (found: " + printable(found, 400) + ")");
  }
  return std::nullopt;
}

std::optional<NumberCell> number_in(const ForeignTable& table, const ForeignTable::Row& row, std::size_t column,
                                    const std::string& name) {
  const std::optional<NumberCell> number = table.number(row, column);
  if (number || row.cells[column].empty()) return number;
  throw FileError(name, "line " + std::to_string(row.line) + ", " + column_name(table, column) + ": '" +
                            printable(row.cells[column], 60) + "' is not a number; correct it, or delete the line");
}

std::string column_option(const ForeignTable& table, std::string_view key, std::size_t column) {
  const std::string title = title_of(table, column);
  const bool by_title = is_alone(table, title) && title.find_first_of(",=") == std::string::npos;
  return std::string(key) + "=" + (by_title ? title : std::to_string(column + 1));
}

void ask(const ForeignTable& table, const std::string& name, const std::string& question,
         std::vector<AmbiguousTable::Reading> readings) {
  std::vector<AmbiguousTable::Column> columns;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    AmbiguousTable::Column column{title_of(table, k).empty() ? std::to_string(k + 1) : title_of(table, k), {}};
    for (std::size_t row = 0; row < std::min<std::size_t>(3, table.rows.size()); ++row)
      column.first_cells += (row == 0 ? "" : "  ") + printable(table.rows[row].cells[k], 50);
    columns.push_back(std::move(column));
  }
  throw AmbiguousTable(name, question, std::move(columns), std::move(readings));
}

void check_first_cells(const ForeignTable& table, const std::string& name) {
  const ForeignTable::Row* word = nullptr;
  std::size_t n_numbers = 0, n_words = 0;
  for (const ForeignTable::Row& row : table.rows) {
    if (table.number(row, 0)) ++n_numbers;
    if (table.number(row, 0) || row.cells[0].empty()) continue;
    ++n_words;
    if (!word) word = &row;
  }
  if (n_numbers > n_words && word)
    ask(table, name,
        "line " + std::to_string(word->line) + " begins with '" + printable(word->cells[0], 60) +
            "' where the others begin with a number; is it a measurement? Delete the line if it is none, and the word "
            "if it is",
        {});
}

int decimals_of(const std::vector<double>& roundings, double unit) {
  double rounding = 0.0;
  for (const double one : roundings) rounding = rounding == 0.0 ? one : std::min(rounding, one);
  return rounding > 0.0 ? static_cast<int>(std::clamp(std::round(-std::log10(2.0 * rounding * unit)), 0.0, 100.0)) : -1;
}

void add_own_columns(const ForeignTable& foreign, const std::vector<ColumnSpec>& own, const std::string& name,
                     Table& table) {
  for (const ColumnSpec& spec : own) {
    const auto column = own_column(foreign, spec.name);
    const bool is_there =
        std::any_of(table.columns.begin(), table.columns.end(), [&](const Column& c) { return c.name == spec.name; });
    if (!column || is_there) continue;
    Column values = empty_column(spec);
    for (const ForeignTable::Row& row : foreign.rows) {
      if (auto* texts = std::get_if<std::vector<std::string>>(&values.values)) {
        texts->push_back(row.cells[*column]);
        continue;
      }
      const auto number = foreign.number(row, *column);
      if (auto* wholes = std::get_if<std::vector<std::int64_t>>(&values.values)) {
        const bool is_whole = number && std::floor(number->value) == number->value && spec.range.holds(number->value);
        if (is_whole) wholes->push_back(static_cast<std::int64_t>(number->value));
        continue;
      }
      if (!row.cells[*column].empty() && !number)
        throw FileError(name, "line " + std::to_string(row.line) + ", column " + spec.name + ": '" +
                                  printable(row.cells[*column]) + "' is not a number");
      std::get<std::vector<double>>(values.values)
          .push_back(number ? number->value : std::numeric_limits<double>::quiet_NaN());
    }
    // drops may have names instead of numbers
    if (const auto* wholes = std::get_if<std::vector<std::int64_t>>(&values.values);
        wholes && wholes->size() < foreign.rows.size())
      continue;
    table.columns.push_back(std::move(values));
  }
}

}  // namespace bouncelab
