// SPDX-License-Identifier: GPL-3.0-or-later
// The numbers of a column or a row, in their order, and the drops that the table tells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tables/foreign_columns.hpp"

namespace bouncelab {

using Reading = AmbiguousTable::Reading;

/// The numbers of a table in their order, in the unit of the table.
struct Sequence {
  struct Value {
    NumberCell number;
    std::size_t line = 0;
    std::int64_t part = 0;  // of the column of drops, or between blank lines
  };
  std::vector<Value> values;
  std::optional<std::size_t> column;  ///< absent: a row
  std::optional<TitleUnit> unit;
  bool has_drops = false;  ///< a column tells them; between blank lines there may be more

  std::vector<double> roundings() const;
};

inline constexpr const char* kClock = "clock times";

/// The unit of a column by its cells, else by its title.
std::optional<TitleUnit> unit_of(const ForeignTable& table, std::size_t column);
ForeignOptions told(std::string as, std::string unit, std::string columns);

/// The first cells of the only row, as far as it is filled. @throws FileError: a gap
Sequence row_of_numbers(const ForeignTable& table, const std::string& name);
/// With the drops by --columns drop=..., a column called drop, or blank lines. @throws FileError, AmbiguousTable
Sequence column_of_numbers(const ForeignTable& table, std::size_t column, const ForeignOptions& options,
                           const std::string& name);
/// "column 'Time (s)', ';' between, decimal comma"
std::string source_in_words(const ForeignTable& table, const Sequence& sequence);

/// Asks about a column whose cells stand in blocks ("1 1 1 2 2 2") that are not the drops found.
/// @param key          of --columns for the column of the numbers
/// @param drop_of_row  -1: the row has no impact
void check_blocks(const ForeignTable& table, std::size_t column, std::string_view key,
                  const std::vector<std::int64_t>& drop_of_row, const ForeignOptions& options, const std::string& name);

/// Heights, where the options or the units of the titles say so; nothing of another table.
/// @throws FileError, AmbiguousTable
std::optional<TakenTable> heights_from_foreign(const ForeignTable& table, const std::string& name,
                                               const ForeignOptions& options);

}  // namespace bouncelab
