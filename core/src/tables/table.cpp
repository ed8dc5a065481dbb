// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"

#include <algorithm>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

template <class T>
const std::vector<T>* values_of(const Table& table, std::string_view name) {
  const Column* column = table.find(name);
  return column ? std::get_if<std::vector<T>>(&column->values) : nullptr;
}

template <class T>
void check_values(const Table& table, const Column& column, const std::vector<T>& values, const ColumnSpec& spec,
                  const std::string& name) {
  const auto bad = std::find_if(values.begin(), values.end(),
                                [&](T value) { return !spec.range.holds(static_cast<double>(value)); });
  if (bad == values.end()) return;
  const auto row = static_cast<std::size_t>(bad - values.begin());
  throw FileError(
      name, table.place_of(row) + ", column " + column.name + ": " + spec.range.why_not(static_cast<double>(*bad)));
}

}  // namespace

bool Range::holds(double value) const {
  if (std::isnan(value)) return may_be_unknown;
  return (without_least ? value > least : value >= least) && value <= greatest;
}

std::string Range::why_not(double value) const {
  if (std::isnan(value)) return "a number is missing";
  return short_number(value) + " is outside " + (without_least ? "(" : "[") + short_number(least) + ", " +
         short_number(greatest) + "]" + (may_be_unknown ? "; leave the cell empty where the value is not known" : "");
}

std::optional<double> Column::rounding() const {
  if (decimals < 0 || decimals > 5) return std::nullopt;
  return std::pow(10.0, -decimals) / std::sqrt(12.0);
}

Column empty_column(const ColumnSpec& spec) {
  if (spec.type == ColumnType::real) return {spec.name, std::vector<double>{}};
  if (spec.type == ColumnType::integer) return {spec.name, std::vector<std::int64_t>{}};
  return {spec.name, std::vector<std::string>{}};
}

std::size_t Table::n_rows() const {
  if (columns.empty()) return 0;
  return std::visit([](const auto& values) { return values.size(); }, columns.front().values);
}

void Table::stands_on(std::size_t row, std::size_t line) {
  if (lines.empty() || line - lines.back().line != row - lines.back().row) lines.push_back({row, line});
}

std::string Table::place_of(std::size_t row) const {
  const auto after =
      std::upper_bound(lines.begin(), lines.end(), row, [](std::size_t r, const Jump& jump) { return r < jump.row; });
  if (after == lines.begin()) return "row " + std::to_string(n_before + row + 1);
  return "line " + std::to_string(std::prev(after)->line + row - std::prev(after)->row);
}

const Column* Table::find(std::string_view name) const {
  for (const Column& column : columns)
    if (column.name == name) return &column;
  return nullptr;
}
const std::vector<double>* Table::reals(std::string_view name) const { return values_of<double>(*this, name); }
const std::vector<std::int64_t>* Table::integers(std::string_view name) const {
  return values_of<std::int64_t>(*this, name);
}
const std::vector<std::string>* Table::texts(std::string_view name) const {
  return values_of<std::string>(*this, name);
}

void check_columns(const Table& table, const std::vector<ColumnSpec>& wanted, const std::string& name) {
  for (const ColumnSpec& spec : wanted) {
    const Column* found = table.find(spec.name);
    if (!found && !spec.required) continue;
    if (!found) throw FileError(name, "column '" + spec.name + "' is missing");
    if (found->values.index() != static_cast<std::size_t>(spec.type))
      throw FileError(name, "column '" + spec.name + "' is of another type");
    if (const auto* reals = std::get_if<std::vector<double>>(&found->values))
      check_values(table, *found, *reals, spec, name);
    if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&found->values))
      check_values(table, *found, *integers, spec, name);
  }
}

std::optional<std::int64_t> whole_number(double value) {
  constexpr double kExact = 9007199254740992.0;
  if (!(std::abs(value) < kExact) || std::trunc(value) != value) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

std::string short_number(double value) { return formatted("%.6g", value); }
}  // namespace bouncelab
