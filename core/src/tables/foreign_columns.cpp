// SPDX-License-Identifier: GPL-3.0-or-later
#include "tables/foreign_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/title_words.hpp"

namespace bouncelab {

bool has_word(std::string_view title, Words wanted) {
  const std::vector<std::string> words = words_of(title);
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::find(wanted.begin(), wanted.end(), word) != wanted.end();
  });
}

Numbers numbers_of(const ForeignTable& table, std::size_t column) {
  Numbers result;
  std::optional<double> before;
  for (const ForeignTable::Row& row : table.rows) {
    const auto number = row.number(column);
    if (!number) continue;
    ++result.n;
    const bool begins = (number->value == 0.0 || number->value == 1.0) && (!before || number->value < *before);
    result.counts = result.counts && (begins || (before && number->value == *before + 1.0));
    before = number->value;
  }
  result.counts = result.counts && result.n > 1;
  return result;
}

std::string title_of(const ForeignTable& table, std::size_t column) {
  return column < table.titles.size() ? table.titles[column] : std::string();
}

std::string column_name(const ForeignTable& table, std::size_t column) {
  const std::string title = title_of(table, column);
  return title.empty() ? "column " + std::to_string(column + 1) : "column '" + printable(title, 60) + "'";
}

std::string titles_in_words(const ForeignTable& table) {
  std::string text;
  for (std::size_t k = 0; k < table.n_columns(); ++k) text += (k == 0 ? "" : ", ") + column_name(table, k);
  return printable(text, 400);
}

std::string format_in_words(const CellFormat& format, std::size_t n_columns) {
  std::string text;
  if (n_columns > 1)
    text = format.separator == '\t'  ? "tabs between"
           : format.separator == ' ' ? "blanks between"
                                     : std::string("'") + format.separator + "' between";
  if (format.decimal == ',') text += (text.empty() ? "" : ", ") + std::string("decimal comma");
  return text;
}

namespace {

std::string digits_of(std::string text) {
  std::erase_if(text, [](char c) { return c < '0' || c > '9'; });
  return text;
}

/// A column by its exact title, or by its number from 1.
std::size_t named_column(const ForeignTable& table, const std::string& wanted, const std::string& name) {
  for (std::size_t k = 0; k < table.titles.size(); ++k)
    if (table.titles[k] == wanted) return k;
  const auto number = number_of(wanted, '.');
  if (number && number->value >= 1.0 && number->value <= static_cast<double>(table.n_columns()) &&
      number->value == std::floor(number->value))
    return static_cast<std::size_t>(number->value) - 1;
  throw FileError(name, "has no column '" + printable(wanted) + "' (found: " + titles_in_words(table) + ")");
}

}  // namespace

std::optional<std::size_t> told_column(const ForeignTable& table, const ForeignOptions& options, std::string_view key,
                                       const std::string& name) {
  for (const std::string_view part : cells_of(options.columns, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos && !part.empty())
      throw InvalidArgument("--columns: '" + printable(part) + "' is no KEY=COLUMN, such as v=speed,eps=e");
    if (part.substr(0, equals) == key) return named_column(table, std::string(part.substr(equals + 1)), name);
  }
  return std::nullopt;
}

std::optional<std::size_t> own_column(const ForeignTable& table, const std::string& title) {
  const auto found = std::find(table.titles.begin(), table.titles.end(), title);
  if (found == table.titles.end()) return std::nullopt;
  return static_cast<std::size_t>(found - table.titles.begin());
}

bool is_summary(const ForeignTable::Row& row) {
  constexpr std::array<std::string_view, 16> kSummaries{
      "mean",   "average",    "avg", "sd",      "std",   "stdev",    "stddev", "dev",
      "mittel", "mittelwert", "mw",  "moyenne", "media", "promedio", "median", ""};
  return std::any_of(row.cells.begin(), row.cells.end(), [&](const std::string& cell) {
    const std::vector<std::string> words =
        cell.empty() || cell.front() <= '9' ? std::vector<std::string>{} : words_of(cell);
    return !words.empty() && !words.front().empty() &&
           std::all_of(words.begin(), words.end(), [&](const std::string& word) {
             return std::find(kSummaries.begin(), kSummaries.end(), word) != kSummaries.end();
           });
  });
}

void check_one_ball(const ForeignTable& table, const std::string& name) {
  constexpr std::array<std::string_view, 20> kBallWords{
      "ball",    "kugel",  "balle", "bille", "palla",  "pallina",    "bola",      "pelota", "floor",    "plate",
      "surface", "ground", "sol",   "boden", "platte", "untergrund", "pavimento", "suelo",  "material", "materiale"};
  constexpr std::array<std::string_view, 4> kOfBall{"type", "kind", "name", "art"};
  for (std::size_t k = 0; k < table.titles.size(); ++k) {
    const std::vector<std::string> words = words_of(table.titles[k]);
    const bool is_of_ball = std::all_of(words.begin(), words.end(), [&](const std::string& word) {
      return word.empty() || has_word(word, kBallWords) || has_word(word, kOfBall);
    });
    if (!is_of_ball || !has_word(table.titles[k], kBallWords)) continue;
    const ForeignTable::Row* first = nullptr;
    for (const ForeignTable::Row& row : table.rows) {
      if (row.cells[k].empty()) continue;
      if (!first) first = &row;
      // a number that is not whole is where the ball or the floor was
      if (const auto number = row.number(k); number && number->value != std::floor(number->value)) break;
      if (words_of(row.cells[k]) != words_of(first->cells[k]) || digits_of(row.cells[k]) != digits_of(first->cells[k]))
        throw FileError(name, "line " + std::to_string(row.line) + ", " + column_name(table, k) + ": '" +
                                  printable(row.cells[k], 60) + "' follows '" + printable(first->cells[k], 60) +
                                  "'; a table is of one ball on one floor, so write one for each");
    }
  }
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
      const auto number = row.number(*column);
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
