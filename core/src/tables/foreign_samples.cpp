// SPDX-License-Identifier: GPL-3.0-or-later
// Speeds and coefficients of restitution of other people's tables.
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/foreign_columns.hpp"
#include "tables/title_words.hpp"

namespace bouncelab {
namespace {

constexpr std::array<std::string_view, 10> kEpsWords{
    "eps",       "epsilon", "\xCE\xB5",       "e", "cor", "restitution", "restitutionskoeffizient",
    "stosszahl", "cr",      "sto\xC3\x9Fzahl"};
constexpr std::array<std::string_view, 10> kSpeedWords{
    "v", "speed", "velocity", "geschwindigkeit", "vitesse", "impact", "velocidad", "v\xE2\x82\x80", "vin", "u"};
constexpr std::array<std::string_view, 8> kAfterWords{"out", "after", "nach", "rebound", "ab", "aus", "apres", "h"};
constexpr std::array<std::string_view, 6> kAlongWords{"t", "x", "tangential", "horizontal", "angular", "terminal"};

/// m/s in one of the unit that a title names; absent: that of another.
std::optional<double> speed_unit_mps(const std::string& title) {
  std::string text;
  for (const char c : title)
    if (c != ' ') text += c;
  const auto has = [&](std::string_view unit) { return text.find(unit) != std::string::npos; };
  if (has("km/h") || has("kmh") || has("kmph")) return 1.0 / 3.6;
  if (has("mm/s") || has("mmps")) return 1e-3;
  if (has("cm/s") || has("cmps")) return 1e-2;
  if (has("m/s") || has("mps")) return 1.0;
  constexpr std::array<std::string_view, 4> kOthers{"mph", "kn", "knots", "fps"};
  if (has("/s") || has("/h") || has("/min") || has_word(title, kOthers)) return std::nullopt;
  return 1.0;
}

/// The one column, of those that are left, whose title has one of the words; absent: none or several.
std::optional<std::size_t> column_with(const ForeignTable& table, Words words, std::optional<std::size_t> except) {
  std::optional<std::size_t> found;
  for (std::size_t k = 0; k < table.titles.size(); ++k) {
    // the speed towards the plate, before the impact
    if (k == except || !has_word(table.titles[k], words) || has_word(table.titles[k], kAfterWords) ||
        has_word(table.titles[k], kAlongWords) || names_derived(table.titles[k]) ||
        2 * numbers_of(table, k).n < table.rows.size())
      continue;
    if (found) return std::nullopt;
    found = k;
  }
  return found;
}

}  // namespace

bool holds_samples(const ForeignTable& table) {
  const auto eps = column_with(table, kEpsWords, {});
  return eps && column_with(table, kSpeedWords, eps);
}

TakenTable samples_from_foreign(const ForeignTable& foreign, const std::string& name, const ForeignOptions& options) {
  check_one_ball(foreign, name);
  auto eps = told_column(foreign, options, "eps", name);
  auto v = told_column(foreign, options, "v", name);
  if (!eps) eps = own_column(foreign, "eps");
  if (!v) v = own_column(foreign, "v_mps");
  if (!eps) eps = column_with(foreign, kEpsWords, v);
  if (!v) v = column_with(foreign, kSpeedWords, eps);
  if (!eps || !v)
    throw FileError(name, "has no columns that are plainly speed and coefficient of restitution (found: " +
                              titles_in_words(foreign) + "); name them: --columns v=COLUMN,eps=COLUMN" +
                              "; impact times are for bouncelab restitution");
  const std::optional<double> unit = speed_unit_mps(title_of(foreign, *v));
  if (!unit) throw FileError(name, column_name(foreign, *v) + " has a unit that is not known; give speeds in m/s");
  const double unit_mps = *unit;
  ForeignTable used = foreign;
  std::erase_if(used.rows,
                [&](const ForeignTable::Row& row) { return !row.number(*v) || !row.number(*eps) || is_summary(row); });
  std::vector<double> speeds, values, speed_roundings, eps_roundings;
  for (const ForeignTable::Row& row : used.rows) {
    const auto v_cell = row.number(*v), eps_cell = row.number(*eps);
    speeds.push_back(unit_mps * v_cell->value);
    values.push_back(eps_cell->value);
    speed_roundings.push_back(v_cell->rounding);
    eps_roundings.push_back(eps_cell->rounding);
  }
  if (used.rows.empty()) throw FileError(name, "has no row with a speed and a coefficient of restitution");
  if (const double typical = median(values); typical > 2.0)  // above 1 is rare, and 2 no ball has by itself
    throw FileError(name, column_name(foreign, *eps) + ": coefficients of " + short_number(typical) +
                              " in the median; are they per cent? Write 0.89 for 89 %");
  TakenTable taken;
  taken.table.columns = {Column{"v_mps", std::move(speeds), decimals_of(speed_roundings, unit_mps)},
                         Column{"eps", std::move(values), decimals_of(eps_roundings, 1.0)}};
  add_own_columns(used, sample_columns(), name, taken.table);
  for (std::size_t k = 0; k < used.rows.size(); ++k) taken.table.stands_on(k, used.rows[k].line);
  const std::size_t n_left_out = foreign.n_left_out + foreign.rows.size() - used.rows.size();
  const std::string how = format_in_words(foreign.format, foreign.n_columns());
  taken.taken_for = "speeds in " +
                    std::string(unit_mps == 1.0    ? "m/s"
                                : unit_mps == 1e-2 ? "cm/s"
                                : unit_mps == 1e-3 ? "mm/s"
                                                   : "km/h") +
                    " (" + column_name(foreign, *v) + ") and coefficients of restitution (" +
                    column_name(foreign, *eps) + (how.empty() ? "" : ", " + how) +
                    "): " + std::to_string(used.rows.size()) + " impacts";
  if (n_left_out > 0) taken.taken_for += "; " + std::to_string(n_left_out) + " lines without numbers left out";
  return taken;
}

}  // namespace bouncelab
