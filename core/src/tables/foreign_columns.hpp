// SPDX-License-Identifier: GPL-3.0-or-later
// What the readers of times and of coefficients share: columns by option, by our titles, in words; questions.
#pragma once

#include <cstddef>
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
std::vector<std::size_t> told_columns(const ForeignTable& table, const ForeignOptions& options, std::string_view key,
                                      const std::string& name);
/// The only one. @throws InvalidArgument of several
std::optional<std::size_t> told_column(const ForeignTable& table, const ForeignOptions& options, std::string_view key,
                                       const std::string& name);
/// The column of an exact title; of two such neither is told.
std::optional<std::size_t> own_column(const ForeignTable& table, std::string_view title);
/// Columns that have our titles keep them, with their values.
void add_own_columns(const ForeignTable& foreign, const std::vector<ColumnSpec>& own, const std::string& name,
                     Table& table);

/// "0.5 s"
bool has_unit(const std::string& cell);
/// A number, nothing where the cell is empty. @throws FileError of any other cell, with its line and column
std::optional<NumberCell> number_in(const ForeignTable& table, const ForeignTable::Row& row, std::size_t column,
                                    const std::string& name);

inline constexpr const char* kClock = "clock times";
/// The unit of a column by its cells, else by its title.
std::optional<TitleUnit> unit_of(const ForeignTable& table, std::size_t column);
/// The unit of columns that are read together. @throws FileError: of another dimension, or two units
std::optional<TitleUnit> unit_of(const ForeignTable& table, const std::vector<std::size_t>& columns,
                                 Dimension dimension, const std::string& name);

/// Two numbers of a row, such as before and after a bounce.
struct PairOfCells {
  const ForeignTable::Row* row = nullptr;
  NumberCell first, second;
};
/// Of the rows that have both. @throws FileError
std::vector<PairOfCells> pairs_in(const ForeignTable& table, std::size_t first, std::size_t second,
                                  const std::string& name);

/// Digits behind the point of numbers in another unit, whose finest is rounded so.
int decimals_of(double rounding);

/// "t=Time (s)"; by number where the title stands twice or holds a sign of the option's own.
std::string column_option(const ForeignTable& table, std::string_view key, std::size_t column);
std::string columns_option(const ForeignTable& table, std::string_view key, const std::vector<std::size_t>& columns);
[[noreturn]] void ask(const ForeignTable& table, const std::string& name, const std::string& question,
                      std::vector<AmbiguousTable::Reading> readings);
/// Asks about a row that begins with a word where most begin with a number: a mean, a remark.
void check_first_cells(const ForeignTable& table, const std::string& name);

}  // namespace bouncelab
