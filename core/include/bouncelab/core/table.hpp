// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace bouncelab {

enum class ColumnType { real, integer, text };

/// A column by name: reals (an empty cell is NaN), integers or texts.
struct Column {
  std::string name;
  std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> values;
};

/// What a reader wants of a column.
struct ColumnSpec {
  std::string name;
  ColumnType type = ColumnType::real;
  bool required = true;
};

/// Columns of equal length: what a CSV file or an HDF5 group holds. File formats and value types both convert to and
/// from tables; neither depends on the other.
struct Table {
  std::vector<Column> columns;
  // of the file it was read from, counted from 1
  std::size_t first_line = 2;              ///< on which rows were first looked for
  std::vector<std::size_t> blank_lines{};  ///< since then, ascending

  /// The line on which a row stood, for messages.
  std::size_t line_of(std::size_t row) const;
  std::size_t n_rows() const;
  bool has(std::string_view name) const;
  /// nullptr where there is no such column or it is of another type.
  const std::vector<double>* reals(std::string_view name) const;
  const std::vector<std::int64_t>* integers(std::string_view name) const;
  const std::vector<std::string>* texts(std::string_view name) const;
};

}  // namespace bouncelab
