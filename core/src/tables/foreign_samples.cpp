// SPDX-License-Identifier: GPL-3.0-or-later
// Speeds and coefficients of restitution of other people's tables: --columns v=...,eps=..., or our v_mps and eps.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"

namespace bouncelab {
namespace {

[[noreturn]] void ask_for_columns(const ForeignTable& table, const std::string& name) {
  std::vector<std::size_t> speeds, others;
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const auto unit = unit_of_title(title_of(table, k));
    if (unit && unit->dimension == Dimension::speed) speeds.push_back(k);
    if (!unit && table.number(table.rows.front(), k)) others.push_back(k);
  }
  std::vector<AmbiguousTable::Reading> readings;
  if (speeds.size() == 2)
    readings.push_back(
        {"speeds before and after",
         {"auto", "auto", column_option(table, "v_in", speeds[0]) + "," + column_option(table, "v_out", speeds[1])}});
  for (const std::size_t v : speeds)
    for (const std::size_t eps : others)
      if (constexpr std::size_t kReadings = 4; readings.size() < kReadings)
        readings.push_back({column_name(table, eps) + " is the coefficient",
                            {"auto", "auto", column_option(table, "v", v) + "," + column_option(table, "eps", eps)}});
  ask(table, name,
      "which columns are the speed and the coefficient of restitution? Name them: --columns v=COLUMN,eps=COLUMN, or "
      "v_in=COLUMN,v_out=COLUMN before and after a bounce; "
      "impact times are for bouncelab restitution",
      std::move(readings));
}

}  // namespace

TakenTable samples_from_foreign(const ForeignTable& foreign, const std::string& name, const ForeignOptions& options) {
  auto eps = told_column(foreign, options, "eps", name), v = told_column(foreign, options, "v", name);
  const auto in = told_column(foreign, options, "v_in", name), out = told_column(foreign, options, "v_out", name);
  const bool are_speeds = in && out;
  if (are_speeds) v = in, eps = out;
  if (!eps) eps = own_column(foreign, "eps");
  if (!v) v = own_column(foreign, "v_mps");
  if (!eps || !v) ask_for_columns(foreign, name);
  const auto unit_of_speed = [&](std::size_t column) {
    const std::optional<TitleUnit> unit = unit_of_title(title_of(foreign, column));
    if (unit && unit->dimension != Dimension::speed)
      throw FileError(name, column_name(foreign, column) + " is no speed: m/s, cm/s, mm/s, km/h, mph, ft/s");
    if (!unit && title_of(foreign, column).find_first_of("([/^") != std::string::npos)
      throw FileError(name,
                      column_name(foreign, column) + " has a unit that is not read: m/s, cm/s, mm/s, km/h, mph, ft/s");
    return unit.value_or(TitleUnit{Dimension::speed, 1.0, "m/s", {}});
  };
  if (!are_speeds && unit_of_title(title_of(foreign, *eps)))
    throw FileError(name, column_name(foreign, *eps) +
                              " has a unit, a coefficient of restitution has none; speeds before and after: --columns "
                              "v_in=COLUMN,v_out=COLUMN");
  const TitleUnit unit = unit_of_speed(*v);
  const double unit_mps = unit.si, after_mps = are_speeds ? unit_of_speed(*eps).si : 1.0;
  ForeignTable used{foreign.format, foreign.titles, {}};
  std::vector<double> speeds, values, sigma_eps;
  double speed_rounding = HUGE_VAL, eps_rounding = HUGE_VAL;
  for (const PairOfCells& pair : pairs_in(foreign, *v, *eps, name)) {
    const NumberCell &speed = pair.first, &coefficient = pair.second;
    used.rows.push_back(*pair.row);
    speeds.push_back(unit_mps * speed.value);
    values.push_back(coefficient.value);
    speed_rounding = std::min(speed_rounding, unit_mps * speed.rounding);
    eps_rounding = std::min(eps_rounding, coefficient.rounding);
    if (!are_speeds) continue;
    if (speed.value == 0.0 || coefficient.value == 0.0)
      throw FileError(name, "line " + std::to_string(pair.row->line) + ": a bounce of speed 0; leave it out");
    speeds.back() = std::abs(speeds.back());  // signed or not
    values.back() = std::abs(after_mps * coefficient.value) / speeds.back();
    sigma_eps.push_back(2.0 / std::sqrt(12.0) * values.back() *
                        std::hypot(speed.rounding / speed.value, coefficient.rounding / coefficient.value));
  }
  if (const double typical = median(values); typical > 2.0)  // above 1 is rare, and 2 no ball has by itself
    throw FileError(name, column_name(foreign, *eps) + ": coefficients of " + short_number(typical) +
                              " in the median; are they per cent? Write 0.89 for 89 %");
  TakenTable taken;
  taken.table.columns = {Column{"v_mps", std::move(speeds), decimals_of(speed_rounding)},
                         Column{"eps", std::move(values), are_speeds ? -1 : decimals_of(eps_rounding)}};
  if (are_speeds) taken.table.columns.push_back({"sigma_eps", std::move(sigma_eps)});
  add_own_columns(used, sample_columns(), name, taken.table);
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
