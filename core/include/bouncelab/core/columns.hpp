// SPDX-License-Identifier: GPL-3.0-or-later
/// The columns of a table of structs, said once: name, what it is, range, and the member that it holds. Tables are
/// written and read, and the page docs/formats.md is made, by what is said. A column is filled and read as a whole: one
/// call a column, not one a cell.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// A column of a table of S.
template <class S>
struct RowColumn {
  ColumnSpec spec;
  std::string text;                                        ///< what it is
  std::function<Column(std::span<const S>)> write;         ///< empty: it is only read
  std::function<void(const Table&, std::span<S>)> read{};  ///< where the table has it; empty: it is only written

  RowColumn&& required() && {
    spec.required = true;
    return std::move(*this);
  }
  RowColumn&& only_written() && {
    read = nullptr;
    return std::move(*this);
  }
};
template <class S>
using RowColumns = std::vector<RowColumn<S>>;

// A cell of a member: integers, reals and texts; "not known" is an absent optional and NaN, an empty cell.
inline std::int64_t cell_of(std::int64_t value) { return value; }
inline double cell_of(double value) { return value; }
inline double cell_of(const std::optional<double>& value) {
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}
inline const std::string& cell_of(const std::string& value) { return value; }
inline void set_cell(std::int64_t& value, std::int64_t cell) { value = cell; }
inline void set_cell(double& value, double cell) { value = cell; }
inline void set_cell(std::optional<double>& value, double cell) {
  value = std::isnan(cell) ? std::nullopt : std::optional(cell);
}
inline void set_cell(std::string& value, const std::string& cell) { value = cell; }

/// A column that may be absent on reading.
/// @param where  pointer to the member, or a function from an S to it: [](auto& s) -> auto& { return s.position_m[0]; }
template <class S, class Where>
RowColumn<S> column(std::string name, Where where, std::string text, Range range = {}) {
  using Cell = std::remove_cvref_t<decltype(cell_of(std::invoke(where, std::declval<const S&>())))>;
  constexpr ColumnType type = std::is_same_v<Cell, double>         ? ColumnType::real
                              : std::is_same_v<Cell, std::int64_t> ? ColumnType::integer
                                                                   : ColumnType::text;
  RowColumn<S> made{{name, type, false, range}, std::move(text), {}};
  made.write = [name, where](std::span<const S> rows) {
    std::vector<Cell> cells;
    cells.reserve(rows.size());
    for (const S& row : rows) cells.push_back(cell_of(std::invoke(where, row)));
    return Column{name, std::move(cells)};
  };
  made.read = [name, where](const Table& table, std::span<S> rows) {
    for (const Column& found : table.columns)
      if (const auto* cells = found.name == name ? std::get_if<std::vector<Cell>>(&found.values) : nullptr)
        for (std::size_t k = 0; k < rows.size(); ++k) set_cell(std::invoke(where, rows[k]), (*cells)[k]);
  };
  return made;
}
template <class S, class T>
RowColumn<S> column(std::string name, T S::*where, std::string text, Range range = {}) {
  return column<S, T S::*>(std::move(name), where, std::move(text), range);
}

template <class S>
Table table_of(const RowColumns<S>& columns, std::span<const S> rows) {
  Table table;
  for (const RowColumn<S>& c : columns)
    if (c.write) table.columns.push_back(c.write(rows));
  return table;
}

/// What a reader wants.
template <class S>
std::vector<ColumnSpec> specs_of(const RowColumns<S>& columns) {
  std::vector<ColumnSpec> specs;
  for (const RowColumn<S>& c : columns)
    if (c.read) specs.push_back(c.spec);
  return specs;
}

/// Rows of a table whose columns were checked (check_columns). What a column that is absent holds stays as S has it.
template <class S>
std::vector<S> rows_of(const RowColumns<S>& columns, const Table& table) {
  std::vector<S> rows(table.n_rows());
  for (const RowColumn<S>& c : columns)
    if (c.read) c.read(table, rows);
  return rows;
}

/// Names and texts, for documents.
template <class S>
Description description_of(const RowColumns<S>& columns) {
  Description all;
  for (const RowColumn<S>& c : columns) {
    Member& member = all.emplace_back();
    member.name = c.spec.name;
    member.text = c.text;
  }
  return all;
}

}  // namespace bouncelab
