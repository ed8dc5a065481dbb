// SPDX-License-Identifier: GPL-3.0-or-later
// The cells of a table that is not ours: numbers, units, separator, decimal sign, titles and rows.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <regex>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"

namespace bouncelab {
namespace {

constexpr std::string_view kBlanks = " \t\r";

/// Half a unit of the last digit of 12.50e-3: 5e-6.
double rounding_of(std::string_view number) {
  const std::size_t exponent_at = std::min(number.find_first_of("eE"), number.size());
  const std::string_view mantissa = number.substr(0, exponent_at);
  const std::size_t point = mantissa.find('.');
  const double n_decimals = point == std::string_view::npos ? 0.0 : static_cast<double>(mantissa.size() - point - 1);
  int exponent = 0;
  if (exponent_at < number.size()) {
    const char* begin = number.data() + exponent_at + 1;
    if (begin < number.data() + number.size() && *begin == '+') ++begin;
    bouncelab::from_chars(begin, number.data() + number.size(), exponent);
  }
  return 0.5 * pow(10.0, exponent - n_decimals);
}

}  // namespace

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  if (separator == ' ') line = trimmed(line, kBlanks);
  while (true) {
    std::size_t end = std::min(separator == ' ' ? line.find_first_of(kBlanks) : line.find(separator), line.size());
    const std::size_t quote = line.find_first_not_of(kBlanks);
    if (end < line.size() && quote < end && line[quote] == '"') {
      const std::size_t closing = line.find('"', quote + 1);  // doubled quotes: two texts that touch
      if (closing != std::string_view::npos && closing > end)
        end = std::min(separator == ' ' ? line.find_first_of(kBlanks, closing) : line.find(separator, closing),
                       line.size());
    }
    cells.push_back(trimmed(line.substr(0, end), " \t\r\""));
    if (end == line.size()) return cells;
    line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line, kBlanks);
  }
}

namespace {

std::optional<NumberCell> plain_number_of(std::string_view cell, char decimal) {
  std::array<char, 512> text{};  // a double without an exponent has up to 400
  if (cell.empty() || cell.size() > text.size()) return std::nullopt;
  if (cell.front() == '+') cell.remove_prefix(1);
  std::copy(cell.begin(), cell.end(), text.begin());
  const std::string_view number(text.data(), cell.size());
  if (decimal == ',') {
    // "1," is the number 1 and a separator
    if (number.find('.') != std::string_view::npos || number.ends_with(',')) return std::nullopt;
    std::replace(text.begin(), text.end(), ',', '.');
  }
  double value = 0.0;
  const auto [end, error] = bouncelab::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(value)) return std::nullopt;
  return NumberCell{value, rounding_of(number)};
}

/// Seconds since 1970 of "2026-11-28T10:00:00.5+01:00", "2026-11-28 10:00:00"; without a zone as if it were UTC.
std::optional<NumberCell> date_and_time(const std::string& cell) {
  static const std::regex kForm(
      R"((\d{4})-(\d\d)-(\d\d)[T ](\d\d):(\d\d):(\d\d)(?:[.,](\d{1,12}))?(?:Z|([+-])(\d\d):?(\d\d))?)");
  std::smatch part;
  if (constexpr std::size_t kLongest = 40; cell.size() > kLongest || !std::regex_match(cell, part, kForm)) return {};
  const auto number = [&](std::size_t k) { return part[k].length() == 0 ? 0 : std::stoi(part[k]); };
  const std::chrono::year_month_day day{std::chrono::year(number(1)),
                                        std::chrono::month(static_cast<unsigned>(number(2))),
                                        std::chrono::day(static_cast<unsigned>(number(3)))};
  if (!day.ok()) return std::nullopt;
  const std::optional<NumberCell> fraction = plain_number_of("0." + part[7].str() + "e0", '.');
  const double zone_s = (part[8] == "-" ? -60.0 : 60.0) * (60 * number(9) + number(10));
  const auto days = static_cast<double>(std::chrono::sys_days(day).time_since_epoch().count());
  return NumberCell{86400.0 * days + 3600.0 * number(4) + 60.0 * number(5) + number(6) - zone_s + fraction->value,
                    fraction->rounding, true};
}

/// "1:02:03.5", "62:03.5": hours and minutes are whole numbers.
std::optional<NumberCell> clock_time(std::string_view cell, char decimal) {
  const std::size_t colon = cell.rfind(':');
  std::optional<NumberCell> result = plain_number_of(cell.substr(colon + 1), decimal);
  if (!result || !(result->value >= 0.0 && result->value < 60.0)) return std::nullopt;
  result->is_clock = true;
  double unit_s = 60.0;
  std::string_view rest = cell.substr(0, colon);
  for (int k = 0; k < 2; ++k, unit_s *= 60.0) {
    const std::size_t before = rest.rfind(':');
    const std::string_view digits = before == std::string_view::npos ? rest : rest.substr(before + 1);
    if (digits.empty() || digits.size() > 4 || digits.find_first_not_of("0123456789") != std::string_view::npos)
      return std::nullopt;
    result->value += unit_s * plain_number_of(digits, '.')->value;
    if (before == std::string_view::npos) return result;
    rest = rest.substr(0, before);
  }
  return std::nullopt;
}

}  // namespace

std::optional<NumberCell> number_of(std::string_view cell, char decimal) {
  if (cell.find(':') == std::string_view::npos) return plain_number_of(cell, decimal);
  return cell.find('-') == std::string_view::npos ? clock_time(cell, decimal) : date_and_time(std::string(cell));
}

std::vector<CellFormat> formats_of(std::string_view line) {
  std::vector<CellFormat> formats;
  if (const std::string_view whole = trimmed(line, kBlanks); number_of(whole, '.') && whole.find(' ') != whole.npos)
    return {{'\0', '.'}};  // date and time
  for (const char separator : {'\t', ';', ',', ' '})
    for (const char decimal : {'.', ','}) {
      if (decimal == ',' && (separator == ',' || line.find(',') == std::string_view::npos)) continue;
      if (separator != ' ' ? line.find(separator) == line.npos : line.find_first_of("\t;") != line.npos) continue;
      int n_numbers = 0, n_others = 0;
      for (const std::string_view cell : cells_of(line, separator))
        if (!cell.empty()) ++(number_of(cell, decimal) ? n_numbers : n_others);
      if (n_numbers > 0 && n_others == 0) formats.push_back({separator, decimal});
    }
  return formats;
}

namespace {

struct KnownUnit {
  std::string_view name;
  Dimension dimension;
  double si;
};
constexpr auto kUnits = std::to_array<KnownUnit>(
    {{"s", Dimension::time, 1.0},          {"sec", Dimension::time, 1.0},         {"ms", Dimension::time, 1e-3},
     {"cs", Dimension::time, 1e-2},        {"ns", Dimension::time, 1e-9},         {"us", Dimension::time, 1e-6},
     {"\xC2\xB5s", Dimension::time, 1e-6},  // micro sign
     {"\xCE\xBCs", Dimension::time, 1e-6},  // Greek mu
     {"min", Dimension::time, 60.0},       {"m", Dimension::length, 1.0},         {"cm", Dimension::length, 1e-2},
     {"mm", Dimension::length, 1e-3},      {"in", Dimension::length, 0.0254},     {"ft", Dimension::length, 0.3048},
     {"mps", Dimension::speed, 1.0},       {"m/s", Dimension::speed, 1.0},        {"cm/s", Dimension::speed, 1e-2},
     {"mm/s", Dimension::speed, 1e-3},     {"km/h", Dimension::speed, 1.0 / 3.6}, {"mph", Dimension::speed, 0.44704},
     {"ft/s", Dimension::speed, 0.3048},   {"in/s", Dimension::speed, 0.0254}});

const KnownUnit* unit_named(std::string_view name) {
  const auto* const known =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const KnownUnit& unit) { return unit.name == name; });
  return known == kUnits.end() ? nullptr : known;
}

}  // namespace

std::optional<TitleUnit> unit_of_title(std::string_view title) {
  title = trimmed(title, kBlanks);
  const auto made = [](const KnownUnit* unit, std::string_view quantity) -> std::optional<TitleUnit> {
    if (unit == nullptr) return std::nullopt;
    return TitleUnit{unit->dimension, unit->si, std::string(unit->name), std::string(trimmed(quantity, kBlanks))};
  };
  // "v_in", "t_min", "t, min" are no inches and no minutes
  const auto is_word = [](std::string_view unit) { return unit == "in" || unit == "min"; };
  struct Around {
    std::string_view before, after;
  };
  for (const auto& [before, after] : std::to_array<Around>({{"(", ")"},
                                                            {"[", "]"},
                                                            {"\xEF\xBC\x88", "\xEF\xBC\x89"},  // full width
                                                            {" in ", ""},                      // "Zeit in s"
                                                            {" en ", ""},                      // "hauteur en cm"
                                                            {",", ""}}))                       // "Höhe, cm"
    if (const std::size_t at = title.rfind(before); title.ends_with(after) && (!after.empty() || at != title.npos)) {
      if (at == title.npos) return std::nullopt;
      std::string_view unit = title.substr(at + before.size());
      unit = trimmed(unit.substr(0, unit.size() - after.size()), kBlanks);
      return before == "," && is_word(unit) ? std::nullopt : made(unit_named(unit), title.substr(0, at));
    }
  // "t / s" and "time_ms", but not "counts / s" and "mass_s": a word that is no quantity of that dimension makes
  // another unit
  constexpr std::array<std::string_view, 16> kQuantityNames{
      "t", "T", "dt", "\xCE\x94t", "\xE2\x88\x86t", "time", "Time", "interval",
      "h", "H", "h0", "height",    "Height",        "v",    "V",    "speed"};
  const std::size_t at = title.find('/') != std::string_view::npos ? title.find('/') : title.rfind('_');
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view quantity = trimmed(title.substr(0, at), kBlanks),
                         unit = trimmed(title.substr(at + 1), kBlanks);
  const bool is_known = std::find(kQuantityNames.begin(), kQuantityNames.end(), quantity) != kQuantityNames.end();
  return !is_known || (title[at] == '_' && is_word(unit)) ? std::nullopt : made(unit_named(unit), quantity);
}

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

/// "1; 0,81; 0,66" of "1, 0,81, 0,66": decimal commas, and a comma with a blank behind it stands between numbers.
std::optional<std::string> with_semicolons(std::string_view row) {
  std::vector<std::string_view> cells = cells_of(row, ' ');
  std::size_t n_commas = 0;
  std::string text;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (cells[k].ends_with(',') == (k + 1 == cells.size())) return std::nullopt;
    if (cells[k].ends_with(',')) cells[k].remove_suffix(1);
    const bool has_comma = cells[k].find(',') != std::string_view::npos;
    if (!number_of(cells[k], ',') || (k > 0 && !has_comma)) return std::nullopt;
    n_commas += has_comma ? 1 : 0;
    (text += text.empty() ? "" : "; ") += cells[k];
  }
  return n_commas < 2 ? std::nullopt : std::optional(text);
}

/// Do lines that end with a comma go on in the next, all of them?
bool are_one_row(std::span<const Line> rows) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::string_view row = trimmed(rows[k].text, kBlanks);
    const bool goes_on = row.ends_with(',') || row.ends_with(';');
    if ((k > 0 && rows[k].follows_blank) || goes_on != (k + 1 < rows.size())) return false;
  }
  // else the last column has empty cells
  return rows.size() == 1 || cells_of(rows.back().text, ',').size() < cells_of(rows.front().text, ',').size() ||
         cells_of(rows.back().text, ';').size() < cells_of(rows.front().text, ';').size();
}

/// The rows that people type, where they are not the lines: all lines as one row, or decimal commas in each.
std::vector<std::string> as_typed(std::span<const Line> rows) {
  std::vector<std::string> typed;
  const bool is_one = are_one_row(rows);
  for (const Line& row : rows)
    if (is_one) {
      if (typed.empty()) typed.emplace_back();
      (typed[0] += typed[0].empty() ? "" : " ") += trimmed(row.text, kBlanks);
    } else if (auto text = with_semicolons(row.text)) {
      typed.push_back(*std::move(text));
    } else {
      return {};
    }
  if (is_one) typed[0] = with_semicolons(typed[0]).value_or(typed[0]);
  return typed;
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

using Formats = std::vector<std::pair<std::size_t, CellFormat>>;  ///< with the number of cells

/// Of several, one number or many, --as takes the fewest and --columns the most. @throws AmbiguousTable
/// @param as  what one number may be
CellFormat told_format(const Formats& formats, const std::vector<const char*>& as, const Line& row,
                       const std::string& name, const ForeignOptions& options) {
  const auto by_cells = [](const auto& a, const auto& b) { return a.first < b.first; };
  if (!options.columns.empty()) return std::max_element(formats.begin(), formats.end(), by_cells)->second;
  if (options.as != "auto") return std::min_element(formats.begin(), formats.end(), by_cells)->second;
  std::vector<AmbiguousTable::Reading> readings;
  const bool is_length = unit_called(options.unit).dimension == Dimension::length;
  for (const char* one : as) {
    if (options.unit != "auto" && is_length != (one == std::string_view("heights"))) continue;
    readings.push_back({one + std::string(", with a decimal comma"), options});
    readings.back().options.as = one;
  }
  readings.push_back({"several, the first a time", options});
  readings.back().options.columns = "t=1";
  throw AmbiguousTable(
      name, "line " + std::to_string(row.number) + ": " + printable(row.text, 60) + " is one number or several", {},
      std::move(readings));
}

CellFormat format_below(std::string_view titles, std::span<const Line> rows, const std::string& name,
                        const ForeignOptions& options) {
  char separator = kOneCell;
  const std::string_view whole = cells_of(rows.front().text, kOneCell).front();
  if (!number_of(whole, '.') && !number_of(whole, ',')) separator = ' ';  // "drop t_s" above "0 0.3"
  for (const char one : {',', ';', '\t'})
    if (cells_of(titles, one).size() > 1) separator = one;
  const CellFormat format{separator, decimal_of(rows, separator)}, one{kOneCell, decimal_of(rows, kOneCell)};
  // is the comma of "Höhe, cm" that of the title?
  const std::vector<std::string_view> cells = cells_of(titles, ',');
  const KnownUnit* unit = separator == ',' && cells.size() == 2 ? unit_named(cells.back()) : nullptr;
  const auto is_number = [&](const Line& row) {
    return number_of(trimmed(row.text, kBlanks), one.decimal).has_value();
  };
  if (unit == nullptr || !std::all_of(rows.begin(), rows.end(), is_number)) return format;
  if (one.decimal == '.') return one;
  const bool is_length = unit->dimension == Dimension::length;
  return told_format({{1, one}, {cells.size(), format}},
                     is_length ? std::vector{"heights"} : std::vector{"times", "intervals"}, rows.front(), name,
                     options);
}

CellFormat format_without_titles(std::span<const Line> rows, const std::string& name, const ForeignOptions& options) {
  Formats formats;
  const auto add_formats = [&](bool are_alike) {  // else each row may be a drop of so many bounces
    for (const char separator : {kOneCell, '\t', ';', ',', ' '}) {
      if (separator == ' ' && rows.front().text.find('\t') != std::string_view::npos) continue;
      const char decimal = decimal_of(rows, separator);
      const std::size_t n_cells = cells_of(rows.front().text, separator).size();
      const bool holds = std::all_of(rows.begin(), rows.end(), [&](const Line& row) {
        const std::vector<std::string_view> cells = cells_of(row.text, separator);
        return (are_alike ? cells.size() == n_cells : cells.size() > 1) &&
               std::all_of(cells.begin(), cells.end(),
                           [&](std::string_view cell) { return cell.empty() || number_of(cell, decimal); });
      });
      if (holds && (n_cells > 1 || separator == kOneCell)) formats.push_back({n_cells, {separator, decimal}});
    }
  };
  add_formats(true);
  if (formats.empty()) add_formats(false);
  if (formats.empty())
    refuse_cells(rows, name,
                 "not every line has the same number of cells, all of them numbers; write a line of titles above, such "
                 "as Time (s), or numbers alone, a drop of two or more in each line");
  const bool is_indented = formats.front().second.separator == kOneCell && formats.front().second.decimal == '.';
  if (formats.size() == 1 || is_indented) return formats.front().second;
  return told_format(formats, {"times", "intervals", "heights"}, rows.front(), name, options);
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
  const std::vector<std::string> typed = n_above == 0 ? as_typed(lines) : std::vector<std::string>();
  if (!typed.empty()) lines.resize(typed.size());
  for (std::size_t k = 0; k < typed.size(); ++k) lines[k].text = typed[k];
  const std::span<const Line> rows = std::span(lines).subspan(n_above);
  ForeignTable table{name, options, {}, {}, {}};
  const auto cells_in = [&](std::string_view line) {
    const std::vector<std::string_view> cells = cells_of(line, table.format.separator);
    return std::vector<std::string>(cells.begin(), cells.end());
  };
  if (n_above == 0) {
    table.format = format_without_titles(rows, name, options);
  } else {
    table.format = format_below(lines[n_above - 1].text, rows, name, options);
    table.titles = cells_in(lines[n_above - 1].text);
    if (std::all_of(table.titles.begin(), table.titles.end(), [](const std::string& cell) { return has_unit(cell); }))
      refuse_cells(std::span(lines).subspan(n_above - 1), name, "");  // the first number, "1 m", is no title
    // what stands below no title may be the digits behind a comma: "1,51" under "Time (s),,"
    while (table.titles.size() > 1 && table.titles.back().empty()) table.titles.pop_back();
  }
  std::size_t n_columns = table.titles.size();
  for (const Line& row : rows)
    if (table.titles.empty()) n_columns = std::max(n_columns, cells_in(row.text).size());
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
    if (table.format.separator == ' ' && cells.size() < n_columns && !table.titles.empty()) most = 0;
    if (most == 0) break;
    cells.resize(n_columns);
    table.rows.push_back({line.number, line.follows_blank, std::move(cells)});
  }
  // the cells of a row would stand below others' titles
  if (most < n_columns && !table.titles.back().empty())
    throw FileError(name, "the line above the numbers has " + std::to_string(n_columns) +
                              " titles, and the rows have fewer cells; write as many, the same separator between all, "
                              "and a unit in parentheses: h (cm)");
  return table;
}

}  // namespace bouncelab
