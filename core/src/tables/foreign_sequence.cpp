// SPDX-License-Identifier: GPL-3.0-or-later
// Which numbers of other people's tables are times or intervals, and of which drop each is.
#include "tables/foreign_sequence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <string_view>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"
#include "tables/title_words.hpp"

namespace bouncelab {
namespace {

constexpr std::array<std::string_view, 15> kIntervalWords{
    "interval",   "intervals", "intervall", "intervalle", "intervalo", "intervallo", "dt",  "\xCE\x94t",
    "difference", "duration",  "dauer",     "flight",     "delta",     "period",     "diff"};
constexpr std::array<std::string_view, 15> kMarkWords{"onset",  "onsets", "start",    "begin",  "stop",
                                                      "impact", "bounce", "aufprall", "stoss",  "rebond",
                                                      "event",  "bote",   "rimbalzo", "marker", "position"};
constexpr std::array<std::string_view, 22> kDropWords{
    "drop",        "trial",   "run",     "series", "serie", "try",    "essai",  "wurf",  "versuch", "throw", "messung",
    "measurement", "attempt", "student", "team",   "group", "gruppe", "groupe", "grupo", "class",   "date",  "datum"};

bool is_unknown(const std::string& cell) {
  constexpr std::array<std::string_view, 8> kNothing{"", "-", "nan", "NaN", "NA", "N/A", "null", "--"};
  return std::find(kNothing.begin(), kNothing.end(), cell) != kNothing.end();
}

bool says_interval(std::string_view title) { return has_word(title, kIntervalWords) && !names_derived(title); }
/// "Run", not "Run 1: Time (s)".
bool names_drop(std::string_view title) { return has_word(title, kDropWords) && !names_time(title); }
/// "Height 1 (m)", "Energy 1", "speed (m/s)": something else.
bool says_other(std::string_view title) {
  constexpr std::array<std::string_view, 40> kOther{"height",
                                                    "h",
                                                    "hoehe",
                                                    "h\xC3\xB6he",
                                                    "hauteur",
                                                    "altezza",
                                                    "altura",
                                                    "energy",
                                                    "energie",
                                                    "energia",
                                                    "m",
                                                    "cm",
                                                    "j",
                                                    "mm",
                                                    "hz",
                                                    "y",
                                                    "v",
                                                    "speed",
                                                    "e",
                                                    "velocity",
                                                    "eps",
                                                    "cor",
                                                    "restitution",
                                                    "vitesse",
                                                    "velocidad",
                                                    "force",
                                                    "level",
                                                    "pressure",
                                                    "mass",
                                                    "temperature",
                                                    "displacement",
                                                    "distance",
                                                    "amplitude",
                                                    "acceleration",
                                                    "geschwindigkeit",
                                                    "epsilon",
                                                    "db",
                                                    "pa",
                                                    "kg",
                                                    "kraft"};
  return names_derived(title) || (!names_time(title) && !says_interval(title) && has_word(title, kOther));
}
bool says_time(std::string_view title) {
  return !says_interval(title) && !says_other(title) && (is_time_title(title) || has_word(title, kMarkWords));
}

/// Numbers in a row each or in a column each: are all of them in order, the same for each, as those of drops are, and
/// how much do the ratios of a drop's neighbouring intervals differ?
struct Lines {
  bool are_ordered = false;
  double spread = HUGE_VAL;  ///< median distance of their logarithms from the median
};
Lines lines_of(const std::vector<std::vector<double>>& lines) {
  std::size_t n_up = 0, n_down = 0;
  std::vector<double> ratios;
  for (std::vector<double> line : lines) {
    const bool up = std::is_sorted(line.begin(), line.end());
    n_up += up ? 1 : 0;
    n_down += std::is_sorted(line.rbegin(), line.rend()) ? 1 : 0;
    if (up && !line.empty()) {
      std::adjacent_difference(line.begin(), line.end(), line.begin());
      line.erase(line.begin());
    }
    for (std::size_t k = 1; k < line.size(); ++k)
      if (line[k - 1] > 0.0 && line[k] > 0.0) ratios.push_back(std::log(line[k] / line[k - 1]));
  }
  Lines result{n_up == lines.size() || n_down == lines.size(), HUGE_VAL};
  if (ratios.empty()) return result;
  const double middle = median(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio - middle);
  result.spread = median(std::move(ratios));
  return result;
}

struct RowsAndColumns {
  Lines rows, columns;
};
RowsAndColumns rows_and_columns(const ForeignTable& table, const std::vector<std::size_t>& columns) {
  std::vector<std::vector<double>> along, down(columns.size());
  for (const ForeignTable::Row& row : table.rows) {
    if (is_summary(row)) continue;
    along.emplace_back();
    for (std::size_t j = 0; j < columns.size(); ++j)
      if (const auto number = row.number(columns[j]))
        along.back().push_back(number->value), down[j].push_back(number->value);
  }
  return {lines_of(along), lines_of(down)};
}

/// Do the numbers rise, or fall, down every column, and not along the rows, or there with ratios that differ more? From
/// heights in their order the first flights fall too.
bool are_columns_of_drops(const ForeignTable& table, const std::vector<std::size_t>& columns) {
  if (table.rows.size() < 3) return false;
  const auto [rows, down] = rows_and_columns(table, columns);
  return down.are_ordered && (!rows.are_ordered || 2.0 * down.spread < rows.spread);
}

[[noreturn]] void refuse_columns_of_drops(const ForeignTable& table, std::size_t one, std::size_t other,
                                          const std::string& name) {
  throw FileError(name, "has a column for each drop (" + column_name(table, one) + ", " + column_name(table, other) +
                            " ...); write them below each other, with a column drop, or name one: --columns t=COLUMN");
}

/// "T1", "T3", "T2": in which order the numbers were measured is not known.
void check_order(const ForeignTable& table, const std::vector<std::size_t>& columns, const std::string& name) {
  std::optional<std::size_t> before;
  double number_before = 0.0;
  for (const std::size_t k : columns) {
    const std::string title = title_of(table, k);
    const std::size_t digit = title.find_first_of("0123456789");
    if (digit == std::string::npos) continue;
    const double number = std::strtod(title.c_str() + digit, nullptr);
    if (before && number < number_before)
      throw FileError(name, column_name(table, k) + " stands behind " + column_name(table, *before) +
                                "; put the columns in the order of the impacts");
    before = k, number_before = number;
  }
}

std::size_t value_column(const ForeignTable& table, const ForeignOptions& options, const std::string& name) {
  if (const auto told = told_column(table, options, "t", name)) return *told;
  if (const auto own = own_column(table, "t_s"); own && options.as != "intervals") return *own;
  std::vector<std::size_t> numeric;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const Numbers numbers = numbers_of(table, k);
    const bool is_mostly = 2 * numbers.n > table.rows.size() || (numbers.n > 0 && says_time(title_of(table, k)));
    if (is_mostly && !names_drop(title_of(table, k))) numeric.push_back(k);
  }
  const auto first = [&](const std::function<bool(std::size_t)>& is) {
    const auto found = std::find_if(numeric.begin(), numeric.end(), is);
    return found == numeric.end() ? std::optional<std::size_t>{} : std::optional(*found);
  };
  const auto counts = [&](std::size_t k) { return numbers_of(table, k).counts; };
  const auto title = [&](std::size_t k) { return title_of(table, k); };
  if (options.as != "intervals") {
    // "Time (s)" before "impact", which may be its number
    if (const auto k =
            first([&](std::size_t c) { return says_time(title(c)) && is_time_title(title(c)) && !counts(c); }))
      return *k;
    if (const auto k = first([&](std::size_t c) { return says_time(title(c)) && !counts(c); })) return *k;
  }
  if (const auto k = first([&](std::size_t c) { return says_interval(title(c)) && !counts(c); })) return *k;
  // whose cells are no numbers, "1,000.0": column_of_values says so
  for (std::size_t k = 0; k < table.titles.size(); ++k)
    if (names_time(title(k)) && says_time(title(k)) && numbers_of(table, k).n == 0) return k;
  std::vector<std::size_t> any = numeric;
  std::erase_if(any, [&](std::size_t c) { return counts(c) || says_other(title(c)); });
  if (any.size() > 1 && !table.titles.empty() && table.rows.size() > 2 &&
      rows_and_columns(table, any).columns.are_ordered)
    refuse_columns_of_drops(table, any[0], any[1], name);
  if (!any.empty()) return any.front();
  if (numeric.size() == 1 && !says_other(title(numeric.front()))) return numeric.front();
  throw FileError(
      name, "has no column of times or intervals (found: " + titles_in_words(table) + "); name it: --columns t=COLUMN");
}

/// Another column of the same title but for its digits: "Time 1 (s)", "Time 2 (s)".
std::optional<std::size_t> twin_of(const ForeignTable& table, std::size_t column) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto without_digits = [&](std::size_t k) {
    std::string text = title_of(table, k);
    std::erase_if(text, is_digit);
    return text;
  };
  for (std::size_t k = 0; k < table.titles.size(); ++k)
    if (k != column && table.titles[k] != table.titles[column] && without_digits(k) == without_digits(column) &&
        numbers_of(table, k).n > 0)
      return k;
  return std::nullopt;
}

/// Those that tell which drop a row is of: the one that was told, else all that are called so ("Run", "Trial") without
/// those with another value in every row, which number the impacts.
std::vector<std::size_t> drop_columns(const ForeignTable& table, std::size_t values, std::optional<std::size_t> told) {
  if (told) return {*told};
  const auto is_one_of_several = [&](std::size_t k) {
    for (std::size_t row = 1; row < table.rows.size(); ++row) {
      const std::string& cell = table.rows[row].cells[k];
      if (cell.empty() || cell == table.rows[row - 1].cells[k]) return true;
    }
    return false;
  };
  std::vector<std::size_t> drops, of_one_row;
  for (std::size_t k = 0; k < table.titles.size(); ++k)
    if (k != values && names_drop(table.titles[k])) (is_one_of_several(k) ? drops : of_one_row).push_back(k);
  if (drops.empty() && !of_one_row.empty()) drops.push_back(of_one_row.front());
  return drops;
}

}  // namespace

std::optional<Sequence> rows_of_values(const ForeignTable& table, const std::string& name) {
  const auto is_numbered = [&](std::size_t k) {
    return title_of(table, k).find_first_of("0123456789") != std::string::npos;
  };
  // a numbered one may be empty, in the first row or in all
  const auto holds_numbers = [&](std::size_t k) {
    return table.rows.front().number(k) ||
           (is_numbered(k) && std::all_of(table.rows.begin(), table.rows.end(), [&](const ForeignTable::Row& row) {
              return row.number(k) || is_unknown(row.cells[k]);
            }));
  };
  std::vector<std::size_t> columns;
  for (std::size_t k = 0; k < table.n_columns(); ++k)
    if (holds_numbers(k) && !says_other(title_of(table, k)) && !has_word(title_of(table, k), kDropWords) &&
        (is_numbered(k) || !numbers_of(table, k).counts))
      columns.push_back(k);
  const auto n_numbered = std::count_if(columns.begin(), columns.end(), is_numbered);
  if (columns.size() < 3) return std::nullopt;
  if (n_numbered < 3 && table.rows.size() > 1) {
    constexpr double kAlike = 0.2;  // ratios of one ball's intervals
    if (const Lines rows = rows_and_columns(table, columns).rows;
        table.titles.empty() && rows.are_ordered && rows.spread < kAlike)
      throw FileError(name,
                      "seems to have a row for each drop, and no titles that say so; name the columns T1, T2, T3 "
                      "... in a line above");
    return std::nullopt;
  }
  if (n_numbered >= 3)
    std::erase_if(columns, [&](std::size_t k) { return !is_numbered(k) && !says_time(title_of(table, k)); });
  check_order(table, columns, name);
  if (are_columns_of_drops(table, columns)) refuse_columns_of_drops(table, columns[0], columns[1], name);
  Sequence sequence;
  sequence.has_series = table.rows.size() > 1;
  sequence.from = table.rows.size() == 1 ? "a row" : "a row for each drop";
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    if (is_summary(table.rows[row])) {
      ++sequence.n_left_out;
      continue;
    }
    std::optional<std::size_t> unset;
    for (const std::size_t k : columns) {
      const auto number = table.rows[row].number(k);
      // what has not been measured is 0 in exports of phyphox
      if (!number || (number->value == 0.0 && k != columns.front())) {
        unset = unset.value_or(k);
        continue;
      }
      if (unset)
        throw FileError(name, "line " + std::to_string(table.rows[row].line) + ", " + column_name(table, *unset) +
                                  ": nothing is written between two numbers, which would become neighbours; write it, "
                                  "or leave out what follows");
      const std::string title = title_of(table, k);
      sequence.says_intervals = sequence.says_intervals || says_interval(title);
      sequence.says_times = sequence.says_times || says_time(title);
      if (sequence.title.empty()) sequence.title = title;
      sequence.values.push_back(
          {number->value, number->rounding, number->is_clock, table.rows[row].line, static_cast<std::int64_t>(row)});
    }
  }
  return sequence;
}

Sequence column_of_values(const ForeignTable& table, const ForeignOptions& options, const std::string& name) {
  for (std::size_t k = 0; k < table.titles.size() && options.columns.empty(); ++k)  // "Trial 1", "Trial 2"
    if (const auto twin = names_drop(table.titles[k]) ? twin_of(table, k) : std::nullopt)
      refuse_columns_of_drops(table, k, *twin, name);
  const std::size_t column = value_column(table, options, name);
  if (const auto twin = twin_of(table, column); twin && options.columns.empty())
    refuse_columns_of_drops(table, column, *twin, name);
  Sequence sequence;
  sequence.title = title_of(table, column);
  sequence.from = table.n_columns() == 1 && sequence.title.empty() ? "" : column_name(table, column);
  sequence.says_intervals = says_interval(sequence.title);
  sequence.says_times = says_time(sequence.title);
  const auto told = told_column(table, options, "drop", name);
  const std::vector<std::size_t> drops = drop_columns(table, column, told);
  sequence.has_series = !drops.empty();
  std::int64_t series = 0;
  std::vector<std::string> before(drops.size());
  const ForeignTable::Row* unknown = nullptr;  // of this series, behind a number
  sequence.values.reserve(table.rows.size());
  for (const ForeignTable::Row& row : table.rows) {
    if (is_summary(row)) {
      ++sequence.n_left_out;
      continue;
    }
    bool begins = false;
    for (std::size_t j = 0; j < drops.size(); ++j) {
      const std::string& cell = row.cells[drops[j]];
      // an empty one is of the drop above: cells that were merged
      if (cell.empty() || cell == before[j]) continue;
      begins = begins || !before[j].empty();
      before[j] = cell;
    }
    if (begins) ++series, unknown = nullptr;
    const bool follows = !sequence.values.empty() && sequence.values.back().series == series;
    const auto number = row.number(column);
    if (column + 1 < row.cells.size() && row.cells[column + 1].find_first_of("0123456789") == std::string::npos &&
        time_unit_s(row.cells[column + 1]))
      throw FileError(name, "line " + std::to_string(row.line) +
                                ": has a unit beside its number; write all times in one, and name it in the title: "
                                "Time (ms)");
    if (!number && (follows || !is_unknown(row.cells[column])) && !unknown) unknown = &row;
    // without it the intervals around would be one; behind the last impact a cell may be empty
    if (unknown && (number || !is_unknown(unknown->cells[column])))
      throw FileError(
          name, "line " + std::to_string(unknown->line) + ", " + column_name(table, column) + ": '" +
                    printable(unknown->cells[column]) +
                    "' is no number: without the time of that impact two intervals would be one; write it, or part the "
                    "drop in two there");
    if (number) sequence.values.push_back({number->value, number->rounding, number->is_clock, row.line, series});
  }
  // one value in all rows tells nothing
  if (!told) sequence.has_series = sequence.has_series && series > 0;
  return sequence;
}

}  // namespace bouncelab
