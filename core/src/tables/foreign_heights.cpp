// SPDX-License-Identifier: GPL-3.0-or-later
// Heights of other people's tables.
#include <algorithm>
#include <cmath>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_sequence.hpp"

namespace bouncelab {
namespace {

/// Before and after a bounce: two columns with a row for each.
struct Pairs {
  std::vector<double> before, after, before_rounding, after_rounding;
  double si = 1.0;
  std::string words;
};

double unit_in(const ForeignOptions& options) {
  if (options.unit == "auto") return 0.0;
  const auto unit = unit_of_title("x (" + options.unit + ")");
  if (!unit || unit->dimension != Dimension::length)
    throw InvalidArgument("--unit " + options.unit + ": heights are in m, cm, mm, in or ft");
  return unit->si;
}

/// The two columns that --columns names. @throws FileError
std::optional<Pairs> pairs_of(const ForeignTable& table, const ForeignOptions& options, const char* before,
                              const char* after, const std::string& name) {
  const auto first = told_column(table, options, before, name), second = told_column(table, options, after, name);
  if (!first || !second) return std::nullopt;
  Pairs pairs;
  const auto a = unit_of(table, *first), b = unit_of(table, *second);
  for (const auto& [one, column] : {std::pair{a, *first}, {b, *second}})
    if (one && one->dimension != Dimension::length)
      throw FileError(name, column_name(table, column) + " is another quantity: its unit is " + one->name);
  if (a && b && a->si != b->si)
    throw FileError(name,
                    column_name(table, *first) + " and " + column_name(table, *second) + " have two units; write one");
  const double said = unit_in(options);
  if (said == 0.0 && !a && !b) ask(table, name, "in which unit are the heights? --unit m, cm, mm, in or ft", {});
  pairs.si = said > 0.0 ? said : a ? a->si : b ? b->si : 1.0;
  check_first_cells(table, name);
  for (const ForeignTable::Row& row : table.rows) {
    const auto x = number_in(table, row, *first, name), y = number_in(table, row, *second, name);
    if (!x || !y) continue;
    if (x->value == 0.0 || y->value == 0.0)
      throw FileError(name, "line " + std::to_string(row.line) + ": a bounce from or to 0; leave it out");
    pairs.before.push_back(pairs.si * std::abs(x->value));
    pairs.after.push_back(pairs.si * std::abs(y->value));
    pairs.before_rounding.push_back(pairs.si * x->rounding);
    pairs.after_rounding.push_back(pairs.si * y->rounding);
  }
  if (pairs.before.empty()) throw FileError(name, "has no row with both numbers");
  pairs.words = column_name(table, *first) + " and " + column_name(table, *second);
  return pairs;
}

TakenTable table_of_heights(std::vector<std::int64_t> drop, std::vector<double> h_m, double rounding_m,
                            const std::string& words, const std::string& name) {
  TakenTable taken;
  const std::int64_t n_drops = drop.back() + 1;
  const std::size_t n_bounces = h_m.size() - static_cast<std::size_t>(n_drops);
  if (n_bounces == 0) throw FileError(name, "one height; two are needed, of the release and of the first bounce");
  std::vector<double> t_s;
  for (std::size_t k = 0; k < h_m.size(); ++k)
    t_s.push_back(k == 0 || drop[k] != drop[k - 1] ? 0.0 : t_s.back() + std::sqrt(8.0 * h_m[k] / kDefaultGravity_mps2));
  const int decimals = decimals_of({rounding_m}, 1.0);
  taken.table.columns = {Column{"drop", std::move(drop)}, Column{"t_s", std::move(t_s)},
                         Column{"fall_m", std::move(h_m), decimals}};
  taken.taken_for = "heights" + words + ": " + std::to_string(n_bounces) +
                    (n_bounces == 1 ? " bounce in " : " bounces in ") + std::to_string(n_drops) +
                    (n_drops == 1 ? " drop" : " drops");
  return taken;
}

/// Each row is a drop of one bounce.
TakenTable table_of_pairs(Pairs pairs, const std::string& name) {
  std::vector<std::int64_t> drop;
  std::vector<double> h_m, sigma;
  double rounding_m = HUGE_VAL;
  for (std::size_t k = 0; k < pairs.before.size(); ++k) {
    drop.insert(drop.end(), 2, static_cast<std::int64_t>(k));
    h_m.insert(h_m.end(), {pairs.before[k], pairs.after[k]});
    rounding_m = std::min({rounding_m, pairs.before_rounding[k], pairs.after_rounding[k]});
  }
  return table_of_heights(std::move(drop), std::move(h_m), rounding_m, " before and after (" + pairs.words + ")", name);
}

/// 0, 1, 2 or 1, 2, 3 from row to row, in each drop anew perhaps: a number of the bounce or of the drop.
bool counts(const ForeignTable& table, std::size_t column) {
  double before = 0.0;
  for (const ForeignTable::Row& row : table.rows) {
    const auto number = table.number(row, column);
    const double here = number ? number->value : before;
    if (here != before && here != before + 1.0 && here != 0.0 && here != 1.0) return false;
    before = here;
  }
  return true;
}

TakenTable heights_of(const ForeignTable& table, const ForeignOptions& options, std::optional<std::size_t> column,
                      const std::string& name) {
  const Sequence sequence = column ? column_of_numbers(table, *column, options, name) : row_of_numbers(table, name);
  double unit_m = unit_in(options);
  if (unit_m == 0.0 && sequence.unit && sequence.unit->dimension == Dimension::length) unit_m = sequence.unit->si;
  const auto& values = sequence.values;
  if (values.empty()) throw FileError(name, "holds no heights");
  if (unit_m == 0.0) {
    std::vector<Reading> readings;
    for (const char* unit : {"m", "cm", "mm"})
      if (const double si = unit_of_title(std::string("x (") + unit + ")")->si * values.front().number.value;
          si > 0.05 && si < 20.0)
        readings.push_back({std::string("in ") + unit, told("heights", unit, options.columns)});
    ask(table, name, "in which unit are the heights?", std::move(readings));
  }
  constexpr double kGrown = 2.25;  // of one ball's bounces none is so much higher than that before it
  std::vector<double> h_m;
  std::vector<std::int64_t> drop;
  double rounding_m = HUGE_VAL;
  std::size_t risen = 0;  // the line of a height that is above the one before it
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!(values[k].number.value > 0.0))
      throw FileError(name, "line " + std::to_string(values[k].line) + ": a height of " +
                                short_number(values[k].number.value) + "; heights are above 0: leave it out");
    h_m.push_back(unit_m * values[k].number.value);
    rounding_m = std::min(rounding_m, unit_m * values[k].number.rounding);  // "1, .81"
    const bool begins =
        k > 0 && (values[k].part != values[k - 1].part || (!sequence.has_drops && h_m[k] > kGrown * h_m[k - 1]));
    constexpr double kRisen = 1.2;  // between its scatter and another drop
    if (k > 0 && !begins && !sequence.has_drops && h_m[k] > kRisen * h_m[k - 1] && risen == 0) risen = values[k].line;
    drop.push_back(k == 0 ? 0 : drop.back() + (begins ? 1 : 0));
  }
  if (sequence.column && options.columns.empty() && !sequence.has_drops) {
    std::vector<std::int64_t> drop_of_row(table.rows.size(), -1);
    for (std::size_t row = 0, k = 0; row < table.rows.size(); ++row)
      if (table.number(table.rows[row], *sequence.column)) drop_of_row[row] = drop[k++];
    check_blocks(table, *sequence.column, "h", drop_of_row, options, name);
  }
  if (risen > 0)
    ask(table, name,
        "line " + std::to_string(risen) +
            ": the ball rose higher than before; a new drop? Write a blank line above it, or a column drop",
        {});
  const std::string how = source_in_words(table, sequence);
  return table_of_heights(std::move(drop), std::move(h_m), rounding_m, how.empty() ? "" : " (" + how + ")", name);
}

}  // namespace

std::optional<TakenTable> heights_from_foreign(const ForeignTable& table, const std::string& name,
                                               const ForeignOptions& options) {
  const auto of = [&](const char* as) { return options.as == as; };
  if (of("times") || of("intervals") || told_column(table, options, "t", name)) return std::nullopt;
  if (auto pairs = pairs_of(table, options, "h0", "h", name)) return table_of_pairs(*std::move(pairs), name);
  if (const auto column = told_column(table, options, "h", name)) return heights_of(table, options, column, name);
  std::vector<std::size_t> measured, lengths;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const auto unit = unit_of(table, k);
    if (!unit) continue;
    measured.push_back(k);
    if (unit->dimension == Dimension::length) lengths.push_back(k);
  }
  const bool is_row = table.rows.size() == 1 && table.n_columns() > 1;
  if (of("heights") && is_row && lengths.size() != 1) return heights_of(table, options, std::nullopt, name);
  if (lengths.size() == 1 && measured.size() == 1 && options.as == "auto")
    for (std::size_t k = 0; k < table.n_columns(); ++k)
      if (k != lengths[0] && title_of(table, k) != "drop" && table.number(table.rows.front(), k) && !counts(table, k)) {
        const std::string h = column_option(table, "h", lengths[0]), h0 = column_option(table, "h0", lengths[0]);
        ask(table, name, "has heights and another column of numbers: what is it?",
            {{"the heights of one ball, one after the other, are in " + column_name(table, lengths[0]),
              told("heights", options.unit, h)},
             {"from there it rose to " + column_name(table, k),
              told("heights", options.unit, h0 + "," + column_option(table, "h", k))}});
      }
  if (lengths.size() == 1 && (measured.size() == 1 || of("heights")))
    return heights_of(table, options, lengths[0], name);
  if (of("heights") && table.n_columns() == 1) return heights_of(table, options, 0, name);
  if (lengths.size() == 2 && measured.size() == 2 && !is_row) {
    std::size_t a = lengths[0], b = lengths[1];
    const auto x = table.number(table.rows.front(), a), y = table.number(table.rows.front(), b);
    if (x && y && std::abs(x->value) < std::abs(y->value)) std::swap(a, b);
    ask(table, name, "two columns are heights: before and after a bounce?",
        {{"from " + column_name(table, a) + " to " + column_name(table, b),
          told("auto", "auto", column_option(table, "h0", a) + "," + column_option(table, "h", b))}});
  }
  if (lengths.size() > 1 && is_row && lengths.size() == measured.size())
    ask(table, name, "has heights in a row: of one ball, from its release on?",
        {{"they are", told("heights", options.unit, {})}});
  if (of("heights")) {
    std::vector<Reading> readings;
    for (std::size_t k = 0; k < table.n_columns(); ++k)
      if (table.number(table.rows.front(), k) && !counts(table, k))
        readings.push_back({"one after the other, " + column_name(table, k),
                            told("heights", options.unit, column_option(table, "h", k))});
    if (readings.size() == 2 && table.n_columns() == 2)
      readings.push_back(
          {"before and after a bounce, " + column_name(table, 0) + " and " + column_name(table, 1),
           told("heights", options.unit, column_option(table, "h0", 0) + "," + column_option(table, "h", 1))});
    ask(table, name, "which column holds heights?", std::move(readings));
  }
  return std::nullopt;
}

}  // namespace bouncelab
