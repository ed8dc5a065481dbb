// SPDX-License-Identifier: GPL-3.0-or-later
// Columns of other people's tables, and the speeds and coefficients of restitution in them.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"

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
      file_(file),
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

bool ForeignOptions::tells_speeds() const {
  constexpr std::array<std::string_view, 4> kKeys{",v=", ",v_in=", ",v_out=", ",eps="};
  return std::any_of(kKeys.begin(), kKeys.end(), [told = "," + columns](const std::string_view key) {
    return told.find(key) != std::string::npos;
  });
}

bool holds_speeds(const ForeignTable& table) {
  if (table.options.tells()) return table.options.tells_speeds();
  bool any = false, others = false;
  for (const std::string& title : table.titles)
    if (const auto unit = unit_of_title(title)) (unit->dimension == Dimension::speed ? any : others) = true;
  return any && !others;
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

std::string place_of(const ForeignTable& table, const ForeignTable::Row& row, std::size_t column) {
  return "line " + std::to_string(row.line) + ", " + column_name(table, column);
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

std::vector<std::size_t> told_columns(const ForeignTable& table, std::string_view key) {
  std::vector<std::size_t> columns;
  for (const std::string_view part : cells_of(table.options.columns, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos && !part.empty())
      throw InvalidArgument("--columns: '" + printable(part) + "' is no KEY=COLUMN, such as v=speed,eps=e");
    if (part.substr(0, equals) != key) continue;
    const std::string_view wanted = part.substr(equals + 1);
    auto column = own_column(table, wanted);
    const auto number = number_of(wanted, '.');
    for (std::size_t k = 0; k < table.n_columns() && !column && number; ++k)
      if (number->value == static_cast<double>(k + 1)) column = k;
    std::string found;
    for (std::size_t k = 0; k < table.n_columns(); ++k) found += (k == 0 ? "" : ", ") + column_name(table, k);
    if (!column) table.refuse("has no column '" + printable(wanted) + "' (found: " + printable(found, 400) + ")");
    columns.push_back(*column);
  }
  return columns;
}

std::optional<std::size_t> told_column(const ForeignTable& table, std::string_view key) {
  const std::vector<std::size_t> columns = told_columns(table, key);
  if (columns.size() > 1) throw InvalidArgument("--columns: " + std::string(key) + "= stands twice; name one column");
  return columns.empty() ? std::nullopt : std::optional(columns.front());
}

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

std::optional<TitleUnit> unit_of(const ForeignTable& table, const std::vector<std::size_t>& columns,
                                 Dimension dimension) {
  std::optional<TitleUnit> common;
  for (const std::size_t column : columns) {
    const auto unit = unit_of(table, column);
    if (unit && unit->dimension != dimension)
      table.refuse(column_name(table, column) + " is another quantity: its unit is " + unit->name);
    if (unit && common && unit->si != common->si)
      table.refuse(column_name(table, columns.front()) + " and " + column_name(table, column) +
                   " have two units; write one");
    if (unit) common = unit;
  }
  return common;
}

bool has_unit(const std::string& cell) {
  const std::size_t behind = std::min(cell.find_first_not_of("0123456789.,+- "), cell.size());
  return behind > 0 && unit_of_title("x (" + cell.substr(behind) + ")");
}

std::optional<NumberCell> number_in(const ForeignTable& table, const ForeignTable::Row& row, std::size_t column) {
  const std::optional<NumberCell> number = table.number(row, column);
  const std::string& cell = row.cells[column];
  if (number || cell.empty()) return number;
  table.refuse(place_of(table, row, column) + ": '" + printable(cell, 60) + "' is not a number; " +
               (has_unit(cell) ? "write the numbers alone, and their unit once, in the title: Time (s)"
                               : "correct it, or delete the line"));
}

std::string column_option(const ForeignTable& table, std::string_view key, std::size_t column) {
  const std::string title = title_of(table, column);
  const bool by_title = is_alone(table, title) && title.find_first_of(",=") == std::string::npos;
  return std::string(key) + "=" + (by_title ? title : std::to_string(column + 1));
}

std::string columns_option(const ForeignTable& table, std::string_view key, const std::vector<std::size_t>& columns) {
  std::string text;
  for (const std::size_t column : columns) text += (text.empty() ? "" : ",") + column_option(table, key, column);
  return text;
}

void ask(const ForeignTable& table, const std::string& question, std::vector<AmbiguousTable::Reading> readings) {
  std::vector<AmbiguousTable::Column> columns;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    AmbiguousTable::Column column{title_of(table, k).empty() ? std::to_string(k + 1) : title_of(table, k), {}};
    for (std::size_t row = 0; row < std::min<std::size_t>(3, table.rows.size()); ++row)
      column.first_cells += (row == 0 ? "" : "  ") + printable(table.rows[row].cells[k], 50);
    columns.push_back(std::move(column));
  }
  throw AmbiguousTable(table.name, question, std::move(columns), std::move(readings));
}

void check_first_cells(const ForeignTable& table) {
  const ForeignTable::Row* word = nullptr;
  std::size_t n_numbers = 0, n_words = 0;
  for (const ForeignTable::Row& row : table.rows) {
    if (table.number(row, 0)) ++n_numbers;
    if (table.number(row, 0) || row.cells[0].empty()) continue;
    ++n_words;
    if (!word) word = &row;
  }
  if (n_numbers > n_words && word)
    ask(table,
        "line " + std::to_string(word->line) + " begins with '" + printable(word->cells[0], 60) +
            "' where the others begin with a number; is it a measurement? Delete the line if it is none, and the word "
            "if it is",
        {});
}

std::vector<PairOfCells> pairs_in(const ForeignTable& table, std::size_t first, std::size_t second) {
  check_first_cells(table);
  std::vector<PairOfCells> pairs;
  for (const ForeignTable::Row& row : table.rows) {
    const auto a = number_in(table, row, first), b = number_in(table, row, second);
    if (a && b) pairs.push_back({&row, *a, *b});
  }
  if (pairs.empty()) table.refuse("has no row with both numbers");
  return pairs;
}

int decimals_of(double rounding) {
  return rounding > 0.0 && std::isfinite(rounding)
             ? static_cast<int>(std::clamp(std::round(-std::log10(2.0 * rounding)), 0.0, 100.0))
             : -1;
}

void add_own_columns(const ForeignTable& foreign, const std::vector<ColumnSpec>& own, Table& table) {
  for (const ColumnSpec& spec : own) {
    const auto column = own_column(foreign, spec.name);
    if (!column || table.has(spec.name)) continue;
    Column values = empty_column(spec);
    auto* const wholes = std::get_if<std::vector<std::int64_t>>(&values.values);
    for (const ForeignTable::Row& row : foreign.rows) {
      const auto number = foreign.number(row, *column);
      if (auto* texts = std::get_if<std::vector<std::string>>(&values.values))
        texts->push_back(row.cells[*column]);
      else if (!wholes)
        std::get<std::vector<double>>(values.values)
            .push_back(number_in(foreign, row, *column) ? number->value : std::numeric_limits<double>::quiet_NaN());
      else if (number && std::floor(number->value) == number->value && spec.range.holds(number->value))
        wholes->push_back(static_cast<std::int64_t>(number->value));
    }
    // drops may have names instead of numbers
    if (!wholes || wholes->size() == foreign.rows.size()) table.columns.push_back(std::move(values));
  }
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

std::vector<std::size_t> bare_columns(const ForeignTable& table, bool with_row_numbers) {
  std::vector<std::size_t> columns;
  for (std::size_t k = 0; k < table.n_columns(); ++k)
    if ((table.number(table.rows.front(), k) || table.rows.front().cells[k].empty()) && !unit_of(table, k) &&
        title_of(table, k) != "drop" && (with_row_numbers || !numbers_rows(table, k)))
      columns.push_back(k);
  return columns;
}

namespace {

std::vector<double> sizes_of(const ForeignTable& table, std::size_t column) {
  std::vector<double> sizes;
  for (const ForeignTable::Row& row : table.rows)
    if (const auto number = table.number(row, column)) sizes.push_back(std::abs(number->value));
  return sizes;
}

}  // namespace

std::vector<std::size_t> before_and_after(const ForeignTable& table, const std::vector<std::size_t>& columns) {
  if (columns.size() != 2) return {};
  std::size_t n = 0, n_falls = 0, n_rises = 0;
  for (const ForeignTable::Row& row : table.rows) {
    const auto x = table.number(row, columns[0]), y = table.number(row, columns[1]);
    if (!x || !y) continue;
    constexpr double kLeast = 0.02;  // what is kept of a speed or a height
    const double before = std::abs(x->value), after = std::abs(y->value);
    ++n;
    n_falls += after >= kLeast * before && after <= before ? 1 : 0;
    n_rises += before >= kLeast * after && before <= after ? 1 : 0;
  }
  if (n == 0 || std::max(n_falls, n_rises) < n) return {};
  return n_falls == n ? columns : std::vector{columns[1], columns[0]};
}

std::vector<Reading> speed_readings(const ForeignTable& table) {
  std::vector<std::size_t> speeds;
  for (std::size_t k = 0; k < table.n_columns(); ++k)
    if (const auto unit = unit_of_title(title_of(table, k)); unit && unit->dimension == Dimension::speed)
      speeds.push_back(k);
  const bool have_unit = !speeds.empty();
  std::vector<std::size_t> bare = bare_columns(table, true);
  if (bare.size() > 2 || have_unit) bare = bare_columns(table, false);
  std::erase_if(bare, [&](std::size_t k) { return sizes_of(table, k).empty(); });
  for (const std::size_t k : bare)
    if (!have_unit && is_speed_of_a_ball(median(sizes_of(table, k)))) speeds.push_back(k);
  std::vector<std::size_t> pair = before_and_after(table, speeds);
  if (pair.empty() && have_unit && speeds.size() == 2) pair = speeds;
  const auto most_of = [&](std::size_t k) {
    const std::vector<double> sizes = sizes_of(table, k);
    return *std::max_element(sizes.begin(), sizes.end());
  };
  std::vector<Reading> readings;
  const auto add = [&](const std::string& meaning, const char* first, std::size_t one, const char* second,
                       std::size_t other) {
    readings.push_back(
        {meaning + (have_unit ? "" : ", in m/s"),
         {"auto", "auto", column_option(table, first, one) + "," + column_option(table, second, other)}});
  };
  if (!pair.empty()) add("speeds before and after a bounce", "v_in", pair[0], "v_out", pair[1]);
  for (const std::size_t v : speeds)
    for (const std::size_t eps : bare) {
      constexpr std::size_t kReadings = 4;
      const bool may_be = have_unit ? most_of(eps) <= 2.0 : most_of(eps) <= 1.0 && most_of(v) > 1.0;
      if (may_be && most_of(eps) > 0.0 && readings.size() < kReadings)
        add("speeds, and " + column_name(table, eps) + " is the coefficient", "v", v, "eps", eps);
    }
  return readings;
}

TakenTable samples_from_foreign(const ForeignTable& foreign) {
  auto eps = told_column(foreign, "eps"), v = told_column(foreign, "v");
  const auto in = told_column(foreign, "v_in"), out = told_column(foreign, "v_out");
  const bool are_speeds = in && out;
  if (are_speeds) v = in, eps = out;
  if (!eps) eps = own_column(foreign, "eps");
  if (!v) v = own_column(foreign, "v_mps");
  const auto is_own = [&](const char* title) { return own_column(foreign, title).has_value(); };
  if ((!eps || !v) && !foreign.options.tells() && is_own("t_s") && is_own("v_mps") && is_own("v_after_mps"))
    foreign.refuse("holds impacts, no coefficients of restitution; make them first: bouncelab restitution " +
                   shell_word(foreign.name));
  if (!eps || !v)
    ask(foreign,
        "which columns are the speed and the coefficient of restitution, or the speeds before and after a bounce "
        "(--columns v=COLUMN,eps=COLUMN or v_in=COLUMN,v_out=COLUMN; impact times are for bouncelab restitution)?",
        speed_readings(foreign));
  const auto unit_of_speed = [&](std::size_t column) {
    const std::optional<TitleUnit> unit = unit_of_title(title_of(foreign, column));
    if (unit && unit->dimension != Dimension::speed)
      foreign.refuse(column_name(foreign, column) + " is no speed: m/s, cm/s, mm/s, km/h, mph, ft/s");
    if (!unit && title_of(foreign, column).find_first_of("([/^") != std::string::npos)
      foreign.refuse(column_name(foreign, column) + " has a unit that is not read: m/s, cm/s, mm/s, km/h, mph, ft/s");
    return unit.value_or(TitleUnit{Dimension::speed, 1.0, "m/s", {}});
  };
  if (!are_speeds && unit_of_title(title_of(foreign, *eps)))
    foreign.refuse(column_name(foreign, *eps) +
                   " has a unit, a coefficient of restitution has none (--columns v_in=COLUMN,v_out=COLUMN: "
                   "speeds before and after)");
  const TitleUnit unit = unit_of_speed(*v);
  const double unit_mps = unit.si, after_mps = are_speeds ? unit_of_speed(*eps).si : 1.0;
  ForeignTable used{foreign.name, foreign.options, foreign.format, foreign.titles, {}};
  std::vector<double> speeds, values, sigma_eps;
  double speed_rounding = HUGE_VAL, eps_rounding = HUGE_VAL;
  for (const PairOfCells& pair : pairs_in(foreign, *v, *eps)) {
    const NumberCell &speed = pair.first, &coefficient = pair.second;
    used.rows.push_back(*pair.row);
    speeds.push_back(unit_mps * speed.value);
    values.push_back(coefficient.value);
    speed_rounding = std::min(speed_rounding, unit_mps * speed.rounding);
    eps_rounding = std::min(eps_rounding, coefficient.rounding);
    if (!are_speeds) continue;
    if (speed.value == 0.0 || coefficient.value == 0.0)
      foreign.refuse("line " + std::to_string(pair.row->line) + ": a bounce of speed 0; leave it out");
    speeds.back() = std::abs(speeds.back());  // signed or not
    values.back() = std::abs(after_mps * coefficient.value) / speeds.back();
    sigma_eps.push_back(2.0 / std::sqrt(12.0) * values.back() *
                        std::hypot(speed.rounding / speed.value, coefficient.rounding / coefficient.value));
  }
  if (const double typical = median(values); typical > 2.0)  // above 1 is rare, and 2 no ball has by itself
    foreign.refuse(column_name(foreign, *eps) + ": coefficients of " + short_number(typical) +
                   " in the median; are they per cent? Write 0.89 for 89 %");
  TakenTable taken;
  taken.table.columns = {Column{"v_mps", std::move(speeds), decimals_of(speed_rounding)},
                         Column{"eps", std::move(values), are_speeds ? -1 : decimals_of(eps_rounding)}};
  if (are_speeds) {  // of which nobody states an error
    taken.table.columns.push_back({"sigma_eps", std::move(sigma_eps)});
    taken.table.columns.push_back({"measured", std::vector<std::string>(used.rows.size(), kOfDigits)});
  }
  add_own_columns(used, sample_columns(), taken.table);
  for (std::size_t k = 0; k < used.rows.size(); ++k) taken.table.stands_on(k, used.rows[k].line);
  const std::size_t n_left_out = foreign.rows.size() - used.rows.size();
  const std::string how = format_in_words(foreign);
  taken.taken_for = "speeds in " + unit.name + " (" + column_name(foreign, *v) +
                    (are_speeds ? ") before and after (" : ") and coefficients of restitution (") +
                    column_name(foreign, *eps) + (how.empty() ? "" : ", " + how) +
                    "): " + std::to_string(used.rows.size()) + " impacts";
  if (n_left_out > 0) taken.taken_for += "; " + std::to_string(n_left_out) + " rows with an empty cell left out";
  return taken;
}

}  // namespace bouncelab
