// SPDX-License-Identifier: GPL-3.0-or-later
// What the readers of times and of coefficients in other people's tables share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// Empty where the table has no titles.
std::string title_of(const ForeignTable& table, std::size_t column);
/// For messages: "column 'Time (s)'", "column 2".
std::string column_name(const ForeignTable& table, std::size_t column);
/// "line 3, column 'Time (s)'"
std::string place_of(const ForeignTable& table, const ForeignTable::Row& row, std::size_t column);
std::string format_in_words(const ForeignTable& table);

/// The columns that --columns names for a key: "t=Time (s),drop=2". @throws InvalidArgument, FileError
std::vector<std::size_t> told_columns(const ForeignTable& table, std::string_view key);
/// The only one. @throws InvalidArgument of several
std::optional<std::size_t> told_column(const ForeignTable& table, std::string_view key);
/// The column of an exact title; of two such neither is told.
std::optional<std::size_t> own_column(const ForeignTable& table, std::string_view title);
/// Columns that have our titles keep them, with their values.
void add_own_columns(const ForeignTable& foreign, const std::vector<ColumnSpec>& own, Table& table);

/// "0.5 s"
bool has_unit(const std::string& cell);
/// A number, nothing where the cell is empty. @throws FileError of any other cell, with its line and column
std::optional<NumberCell> number_in(const ForeignTable& table, const ForeignTable::Row& row, std::size_t column);

inline constexpr const char* kClock = "clock times";
/// The unit of a column by its cells, else by its title.
std::optional<TitleUnit> unit_of(const ForeignTable& table, std::size_t column);
/// The unit of columns that are read together. @throws FileError: of another dimension, or two units
std::optional<TitleUnit> unit_of(const ForeignTable& table, const std::vector<std::size_t>& columns,
                                 Dimension dimension);

/// Two numbers of a row, such as before and after a bounce.
struct PairOfCells {
  const ForeignTable::Row* row = nullptr;
  NumberCell first, second;
};
/// Of the rows that have both. @throws FileError
std::vector<PairOfCells> pairs_in(const ForeignTable& table, std::size_t first, std::size_t second);

/// Digits behind the point of numbers in another unit, whose finest is rounded so.
int decimals_of(double rounding);

/// "t=Time (s)"; by number where the title stands twice or holds a sign of the option's own.
std::string column_option(const ForeignTable& table, std::string_view key, std::size_t column);
std::string columns_option(const ForeignTable& table, std::string_view key, const std::vector<std::size_t>& columns);
using Reading = AmbiguousTable::Reading;

/// Whole numbers from 0 or 1 on: of the rows, the bounces, the drops.
bool numbers_rows(const ForeignTable& table, std::size_t column);
/// Columns of numbers without a unit that are not called drop.
std::vector<std::size_t> bare_columns(const ForeignTable& table, bool with_row_numbers);
/// Two columns as before and after bounces: in each row the second is smaller, in size. Empty where they are not.
std::vector<std::size_t> before_and_after(const ForeignTable& table, const std::vector<std::size_t>& columns);
/// Which columns may be speeds before and after, or speeds and coefficients of restitution.
std::vector<Reading> speed_readings(const ForeignTable& table);
[[noreturn]] void ask(const ForeignTable& table, const std::string& question,
                      std::vector<AmbiguousTable::Reading> readings);
/// Asks about a row that begins with a word where most begin with a number: a mean, a remark.
void check_first_cells(const ForeignTable& table);

// ---- numbers in their order, the drops that the table tells, and what else stands beside them

/// What is read: a column, several of which each is a drop, or rows of which each is one.
struct Selection {
  std::vector<std::size_t> columns;
  Dimension dimension = Dimension::time;
  bool by_rows = false;

  const char* key() const { return dimension == Dimension::length ? "h" : "t"; }
};

/// The numbers of a table in their order, in the unit of the table.
struct Sequence {
  struct Value {
    NumberCell number;
    std::size_t line = 0;
    std::int64_t part = 0;  // of the column of drops, or between blank lines
  };
  std::vector<Value> values;
  std::optional<TitleUnit> unit;
  bool has_drops = false;  ///< the table tells them; between blank lines there may be more

  /// The number before it in the same part.
  const NumberCell* before(std::size_t k) const {
    return k > 0 && values[k - 1].part == values[k].part ? &values[k - 1].number : nullptr;
  }
};

/// Do the numbers rise from row to row, or in each drop again, for three impacts or more?
bool rises(const Sequence& sequence);
/// Is each step as long as the first, within the rounding?
bool has_equal_steps(const Sequence& sequence);

/// Does it rise three times in succession somewhere, and fall so elsewhere? A position does; times only rise, and
/// intervals and heights fall until the next drop.
bool goes_up_and_down(const Sequence& sequence);
/// Rows of a video, at least.
inline constexpr std::size_t kFrames = 8;
/// Asks about a column that goes on by equal steps, or up and down.
[[noreturn]] void ask_about_path(const ForeignTable& table, std::size_t column, bool has_steps,
                                 std::vector<Reading> readings);

TitleUnit unit_called(const std::string& name);
/// In the median, in the unit of the numbers; 0 of a single time.
double typical_interval(const Sequence& sequence, bool intervals);
/// From 0.02 to 30 m/s?
bool is_speed_of_a_ball(double v_mps);
/// Are numbers in this unit those of a ball that is dropped in a room?
bool are_of_a_ball(const Sequence& sequence, const std::string& as, double si);
/// What numbers without a unit, or of a unit that is known, may be.
/// @param as  "times", "intervals", "heights" in the order in which they are offered
std::vector<Reading> readings_of(const Sequence& sequence, const std::vector<const char*>& as, bool has_unit,
                                 const ForeignOptions& options, const std::string& columns);
/// Which columns or rows are read. @throws FileError, AmbiguousTable
Selection selection_of(const ForeignTable& table);

}  // namespace bouncelab
