// SPDX-License-Identifier: GPL-3.0-or-later
// The numbers of columns or rows, in their order, the drops that the table tells, and what else stands beside them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tables/foreign_columns.hpp"

namespace bouncelab {

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

/// With the drops by --columns drop=..., a column called drop, or blank lines. @throws FileError, AmbiguousTable
Sequence numbers_of(const ForeignTable& table, const Selection& selection, const ForeignOptions& options,
                    const std::string& name);
/// "column 'Time (s)', ';' between, decimal comma"
std::string source_in_words(const ForeignTable& table, const Selection& selection);

/// Whole numbers from 0 or 1 on: of the rows, the bounces, the drops.
bool numbers_rows(const ForeignTable& table, std::size_t column);
/// Do the numbers rise from row to row, or in each drop again, for three impacts or more?
bool rises(const Sequence& sequence);
/// Does every part rise, or every part fall, over three numbers or more?
bool goes_one_way(const Sequence& sequence);
/// Is each step as long as the first, within the rounding?
bool has_equal_steps(const Sequence& sequence);

using Reading = AmbiguousTable::Reading;

TitleUnit unit_called(const std::string& name);
/// In the median, in the unit of the numbers; 0 of a single time.
double typical_interval(const Sequence& sequence, bool intervals);
/// Are numbers in this unit those of a ball that is dropped in a room?
bool are_of_a_ball(const Sequence& sequence, const std::string& as, double si);
/// What numbers without a unit, or of a unit that is known, may be.
/// @param as  "times", "intervals", "heights" in the order in which they are offered
std::vector<Reading> readings_of(const Sequence& sequence, const std::vector<const char*>& as, bool has_unit,
                                 const ForeignOptions& options, const std::string& columns);
/// Which columns or rows are read. @throws FileError, AmbiguousTable
Selection selection_of(const ForeignTable& table, const ForeignOptions& options, const std::string& name);

/// Asks about columns that may tell more than is read: blocks ("1 1 1 2 2 2") that are not the drops found, words in
/// some rows. @throws FileError: a column names another unit
/// @param drop_of_value  of each number of the sequence
void check_others(const ForeignTable& table, const Selection& selection, const Sequence& sequence,
                  const TitleUnit& unit, const std::vector<std::int64_t>& drop_of_value, const ForeignOptions& options,
                  const std::string& name);

}  // namespace bouncelab
