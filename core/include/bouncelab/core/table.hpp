// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iosfwd>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {

enum class ColumnType { real, integer, text };  // in the order of Column::values
/// A column by name: reals (an empty cell is NaN), integers or texts.
struct Column {
  std::string name;
  std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> values;
  int decimals = -1;  ///< of reals that were texts: the most digits behind a point; -1: not known

  /// Standard deviation of what rounding to so many decimals took: 10^-decimals/sqrt(12). Absent where that is not
  /// known or there are more than five: such numbers are computed ones.
  std::optional<double> rounding() const;
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
  /// nullptr where there is no such column.
  const Column* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }
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

/// Bytes of one row of a table of text. The longest row of ours has 40 numbers of 24 characters and two names of files
/// of 4,096 bytes, doubled where all are quotes: 20 kB. What is fifty times longer is no table, and is refused before
/// it fills the memory.
inline constexpr std::size_t kLongestRow_bytes = 1 << 20;

/// The lines of a table of text, in constant memory. Something that is no text at all is refused at its first block.
class LineReader {
 public:
  /// @param in    must outlive this
  /// @param name  of the file, for messages
  LineReader(std::istream& in, std::string name);
  /// The next line, decoded (TextDecoder), without its line feed (a carriage return before it stays); false after the
  /// last. What the end of the file cuts off is a line too.
  /// @throws FileError naming the line: longer than kLongestRow_bytes, a byte 0 in it, reading failed; what is no text
  bool next(std::string& line);
  /// Of the line read last, counted from 1.
  std::size_t number() const { return number_; }
  const std::string& name() const { return name_; }

 private:
  bool fill();
  void append(const char* end, std::string& line);

  std::istream* in_;
  std::string name_;
  TextDecoder decoder_;
  std::vector<char> block_;
  std::string text_;
  const char *at_ = nullptr, *end_ = nullptr;
  std::size_t number_ = 0;
};

/// Opens a table of text, by its name or from a pipe. @throws FileError: absent, a folder, not readable
std::ifstream open_text(const std::filesystem::path& path);

/// Reads the columns wanted from a CSV file: one header line, comma, '.', quoted cells with commas, quotes and line
/// breaks as in RFC 4180, CRLF or LF, a byte order mark is skipped. Other columns are passed over. Columns come in the
/// order of `wanted`. "nan" is as an empty cell; 3.0 is an integer too.
/// @throws FileError naming line and column: file missing or empty, no text, a required column absent, a wanted one
///         named twice, a row of another length or longer than kLongestRow_bytes, a quote that is not closed or that
///         text follows, a cell that is no number of its type (an empty cell of a real column is NaN; of an integer
///         column an error)
Table read_csv(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
/// @param name  of the file, for messages
Table read_csv(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted);

/// As read_csv, a piece of the file at a time: tables longer than the memory.
class TableReader {
 public:
  TableReader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
  /// @param in  must outlive this
  TableReader(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted);
  /// A table that is in memory already: its first piece is all of it.
  explicit TableReader(Table table);
  /// The next rows of the file, at most so many; none after the last. @throws FileError
  Table next(std::size_t max_rows);

 private:
  struct State;
  std::shared_ptr<State> state_;  // of a file
  Table in_memory_;
};

/// Writes header and rows; reals with the fewest digits that read back to the same double (at most 17), NaN as an
/// empty cell. Texts are written byte for byte; quoted where they hold commas, quotes or line breaks, or begin or end
/// with a blank.
void write_csv(std::ostream& out, const Table& table);
/// Rows only: a long table can be written in pieces.
void write_csv_rows(std::ostream& out, const Table& table);

// The columns of a table of structs, said once: name, what it is, range, and the member that it holds. Tables are
// written and read, and the page docs/formats.md is made, by what is said. A column is filled and read as a whole: one
// call a column, not one a cell.

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
    const Column* found = table.find(name);
    if (const auto* cells = found ? std::get_if<std::vector<Cell>>(&found->values) : nullptr)
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

/// Names and texts, for documents; they are those of `columns`.
template <class S>
std::vector<Member> description_of(const RowColumns<S>& columns) {
  std::vector<Member> all;
  for (const RowColumn<S>& c : columns) all.push_back({c.spec.name, c.text});
  return all;
}

}  // namespace bouncelab
