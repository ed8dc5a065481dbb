// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
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

/// The numbers that a column may hold; beyond them lies no ball, and a computation with them would only look like one.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  bool without_least = false;
  bool may_be_unknown = true;  ///< NaN: an empty cell of a real column

  bool holds(double value) const;
  /// "-1 is outside (0, 1e+10]", for messages.
  std::string why_not(double value) const;
};
/// (0, greatest]
constexpr Range positive_up_to(double greatest) { return {0.0, greatest, true, true}; }
/// `range` where every row must have a value.
constexpr Range known(Range range) { return {range.least, range.greatest, range.without_least, false}; }
/// Of columns that count from 0: more than any machine holds, and not so many that the next number overflows.
inline constexpr Range kIndexRange{0.0, 1e15};
/// Of times [s]: 300 years either way.
inline constexpr Range kTimeRange_s{-1e10, 1e10, false, false};

/// What a reader wants of a column.
struct ColumnSpec {
  std::string name;
  ColumnType type = ColumnType::real;
  bool required = true;
  Range range{};
};

/// A column of this name and type, without rows.
Column empty_column(const ColumnSpec& spec);

/// Columns of equal length: what a CSV file holds. File formats and value types both convert to and
/// from tables; neither depends on the other.
struct Table {
  /// A row that does not stand on the line after that of the row before, and its line, counted from 1.
  struct Jump {
    std::size_t row, line;
  };

  std::vector<Column> columns;
  std::vector<Jump> lines{};  ///< ascending; none: the rows are not lines of a file
  std::size_t n_before = 0;   ///< rows of the file before these, where they are a piece of it; with lines: not needed

  /// Notes the line on which a row begins; in the order of the rows.
  void stands_on(std::size_t row, std::size_t line);
  /// Where a row stood, for messages: "line 7", or "row 6" where it was no line.
  std::string place_of(std::size_t row) const;
  std::size_t n_rows() const;
  /// Puts the rows of `more` below these. The lines on which the rows of either stood are forgotten.
  /// @throws InvalidArgument  unless `more` is another table with the same columns: names, types and order
  void append(const Table& more);
  bool has(std::string_view name) const;
  /// nullptr where there is no such column or it is of another type.
  const std::vector<double>* reals(std::string_view name) const;
  const std::vector<std::int64_t>* integers(std::string_view name) const;
  const std::vector<std::string>* texts(std::string_view name) const;
};

/// Checks that the required columns are there, and that all numbers are in the ranges of their columns.
/// @param name  of the file, for messages
/// @throws FileError naming the column and the first row outside, by its line
void check_columns(const Table& table, const std::vector<ColumnSpec>& wanted, const std::string& name);

/// A real that stands for an integer (3.0, as other programs write it where a column has gaps); absent where it has a
/// fraction, is not finite, or is so large (2^53) that not every integer is a real.
std::optional<std::int64_t> whole_number(double value);

/// A number for a message, with six digits at most: 0.1, 1e+308.
std::string short_number(double value);

}  // namespace bouncelab
