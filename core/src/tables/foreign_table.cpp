// SPDX-License-Identifier: GPL-3.0-or-later
// The cells of a table that is not ours: its separator, decimal sign, titles and rows.
#include "bouncelab/core/foreign_table.hpp"

#include <algorithm>
#include <regex>
#include <utility>

#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kMostColumns = 1024;

struct Line {
  std::size_t number = 0;
  bool follows_blank = false;
  std::string_view text;
};

/// Does the line hold a number that stands by itself? Between blanks only where all are numbers: "Bounce 1 (s)".
bool holds_a_number(std::string_view line) {
  for (const char separator : {'\t', ';', ','})
    for (const std::string_view cell : cells_of(line, separator))
      if (number_of(cell, '.') || number_of(cell, ',')) return true;
  return !formats_of(line).empty();
}

/// Lines that are not blank, no comments above the first number, no frequencies of Audacity's labels (\).
std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  bool has_numbers = false, follows_blank = false;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \t\r,;") == std::string_view::npos) {
      follows_blank = true;
      continue;
    }
    if (line.front() == '\\' || line.starts_with("sep=") || (!has_numbers && line.front() == '#')) continue;
    has_numbers = has_numbers || holds_a_number(line);
    lines.push_back({number, std::exchange(follows_blank, false), line});
  }
  return lines;
}

/// Says so where a number has its unit beside it, "1 m".
[[noreturn]] void refuse_cells(std::span<const Line> rows, const std::string& name, const std::string& why) {
  constexpr std::size_t kSearched = 200;
  static const std::regex kForm(R"((?:^|[\s,;])([\d.,]*\d ?(?:min|sec|ms|us|s|mm|cm|m|in|ft))(?=$|[\s,;]))");
  std::smatch found;
  for (const Line& row : rows)
    if (const std::string text(row.text.substr(0, kSearched)); std::regex_search(text, found, kForm))
      throw FileError(name, "line " + std::to_string(row.number) + ": '" + found[1].str() +
                                "': write the numbers alone and choose their unit (--unit), or name it in a line of "
                                "titles above, such as Time (s) or h (m)");
  throw FileError(name,
                  "line " + std::to_string(rows.front().number) + ": " + printable(rows.front().text, 60) + ": " + why);
}

/// What people type, as one row: lines that end with a comma go on in the next; "1, 0,81, 0,66" has decimal commas, and
/// a comma with a blank behind it stands between numbers. Empty: the lines are rows.
std::string as_typed(std::span<const Line> rows) {
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::string_view row = rows[k].text.substr(0, rows[k].text.find_last_not_of(" \t\r") + 1);
    const bool goes_on = row.ends_with(',') || row.ends_with(';');
    if ((k > 0 && rows[k].follows_blank) || goes_on != (k + 1 < rows.size())) return {};
    (text += row) += k + 1 < rows.size() ? " " : "";
  }
  if (rows.size() > 1 && cells_of(rows.back().text, ',').size() >= cells_of(rows.front().text, ',').size() &&
      cells_of(rows.back().text, ';').size() >= cells_of(rows.front().text, ';').size())
    return {};  // the last column has empty cells
  std::vector<std::string_view> cells = cells_of(text, ' ');
  std::size_t n_commas = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (cells[k].ends_with(',') == (k + 1 == cells.size())) return text;
    if (cells[k].ends_with(',')) cells[k].remove_suffix(1);
    const bool has_comma = cells[k].find(',') != std::string_view::npos;
    if (!number_of(cells[k], ',') || (k > 0 && !has_comma)) return text;
    n_commas += has_comma ? 1 : 0;
  }
  if (n_commas < 2) return text;
  std::string with_semicolons;
  for (const std::string_view cell : cells) (with_semicolons += with_semicolons.empty() ? "" : "; ") += cell;
  return with_semicolons;
}

/// A decimal comma where a cell is no number without one.
char decimal_of(std::span<const Line> rows, char separator) {
  for (const Line& row : rows)
    for (const std::string_view cell : cells_of(row.text, separator))
      if (!number_of(cell, '.') && number_of(cell, ',')) return ',';
  return '.';
}

/// A cell that only a quote or a title above makes one: the whole line.
constexpr char kOneCell = '\0';

CellFormat format_below(std::string_view titles, std::span<const Line> rows) {
  char separator = kOneCell;
  const std::string_view whole = cells_of(rows.front().text, kOneCell).front();
  if (!number_of(whole, '.') && !number_of(whole, ',')) separator = ' ';  // "drop t_s" above "0 0.3"
  for (const char one : {',', ';', '\t'})
    if (cells_of(titles, one).size() > 1) separator = one;
  return {separator, decimal_of(rows, separator)};
}

CellFormat format_without_titles(std::span<const Line> rows, const std::string& name, const ForeignOptions& options) {
  std::vector<std::pair<std::size_t, CellFormat>> formats;  // with the number of cells
  for (const char separator : {kOneCell, '\t', ';', ',', ' '}) {
    if (separator == ' ' && rows.front().text.find('\t') != std::string_view::npos) continue;
    const char decimal = decimal_of(rows, separator);
    const std::size_t n_cells = cells_of(rows.front().text, separator).size();
    const bool holds = std::all_of(rows.begin(), rows.end(), [&](const Line& row) {
      const std::vector<std::string_view> cells = cells_of(row.text, separator);
      return cells.size() == n_cells && std::all_of(cells.begin(), cells.end(), [&](std::string_view cell) {
               return cell.empty() || number_of(cell, decimal);
             });
    });
    if (holds && (n_cells > 1 || separator == kOneCell)) formats.push_back({n_cells, {separator, decimal}});
  }
  if (formats.empty())
    refuse_cells(rows, name,
                 "not every line has the same number of cells, all of them numbers; write a line of titles above, such "
                 "as Time (s)");
  const bool is_indented = formats.front().second.separator == kOneCell && formats.front().second.decimal == '.';
  if (formats.size() == 1 || is_indented) return formats.front().second;
  const auto by_cells = [](const auto& a, const auto& b) { return a.first < b.first; };
  if (!options.columns.empty()) return std::max_element(formats.begin(), formats.end(), by_cells)->second;
  if (options.as != "auto") return std::min_element(formats.begin(), formats.end(), by_cells)->second;
  ForeignOptions times = options, intervals = options, several = options;
  times.as = "times", intervals.as = "intervals", several.columns = "t=1";
  throw AmbiguousTable(name,
                       "line " + std::to_string(rows.front().number) + ": " + printable(rows.front().text, 60) +
                           " is one number or several",
                       {},
                       {{"times, with a decimal comma", times},
                        {"intervals, with a decimal comma", intervals},
                        {"several, the first a time", several}});
}

}  // namespace

ForeignTable read_foreign_table(std::string_view text, const std::string& name, const ForeignOptions& options) {
  std::vector<Line> lines = lines_of(text);
  if (lines.empty()) throw FileError(name, "is empty; a table of times or intervals, or marks are needed");
  const auto first =
      std::find_if(lines.begin(), lines.end(), [](const Line& line) { return holds_a_number(line.text); });
  if (first == lines.end())  // below the titles numbers are looked for
    refuse_cells(std::span(lines).subspan(lines.size() > 1 ? 1 : 0), name,
                 "no line holds numbers by themselves; a unit belongs into the title above them, Time (s)");
  const auto n_above = static_cast<std::size_t>(first - lines.begin());
  const std::string typed = n_above == 0 ? as_typed(lines) : "";
  if (!typed.empty()) lines = {{first->number, false, typed}};
  const std::span<const Line> rows = std::span(lines).subspan(n_above);
  ForeignTable table;
  const auto cells_in = [&](std::string_view line) {
    const std::vector<std::string_view> cells = cells_of(line, table.format.separator);
    return std::vector<std::string>(cells.begin(), cells.end());
  };
  if (n_above == 0) {
    table.format = format_without_titles(rows, name, options);
  } else {
    table.format = format_below(lines[n_above - 1].text, rows);
    table.titles = cells_in(lines[n_above - 1].text);
    if (std::all_of(table.titles.begin(), table.titles.end(), [](const std::string& cell) { return has_unit(cell); }))
      refuse_cells(std::span(lines).subspan(n_above - 1), name, "");  // the first number, "1 m", is no title
    // what stands below no title may be the digits behind a comma: "1,51" under "Time (s),,"
    while (table.titles.size() > 1 && table.titles.back().empty()) table.titles.pop_back();
  }
  const std::size_t n_columns = table.titles.empty() ? cells_in(rows.front().text).size() : table.titles.size();
  if (n_columns > kMostColumns)
    throw FileError(
        name, "has " + std::to_string(n_columns) + " columns; at most " + std::to_string(kMostColumns) + " are read");
  table.rows.reserve(rows.size());
  std::size_t most = 0;
  for (const Line& line : rows) {
    std::vector<std::string> cells = cells_in(line.text);
    while (cells.size() > n_columns && cells.back().empty()) cells.pop_back();
    if (cells.size() > n_columns)
      throw FileError(name,
                      "line " + std::to_string(line.number) + " has " + std::to_string(cells.size()) +
                          " cells, and the titles are " + std::to_string(n_columns) +
                          "; write a title above each column and the same separator in all lines, or delete the line");
    most = std::max(most, cells.size());
    if (table.format.separator == ' ' && cells.size() < n_columns) most = 0;
    if (most == 0) break;
    cells.resize(n_columns);
    table.rows.push_back({line.number, line.follows_blank, std::move(cells)});
  }
  // the cells of a row would stand below others' titles
  if (most < n_columns && !table.titles.back().empty())
    throw FileError(name, "the line above the numbers has " + std::to_string(n_columns) +
                              " titles, and the rows have fewer cells; write as many, the same separator between all");
  return table;
}

}  // namespace bouncelab
