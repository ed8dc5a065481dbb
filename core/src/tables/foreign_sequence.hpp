// SPDX-License-Identifier: GPL-3.0-or-later
// Which numbers of other people's tables are times or intervals, and of which drop each is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/foreign_table.hpp"

namespace bouncelab {

/// A number with what else is known of its place.
struct Found {
  double value = 0.0;
  double rounding = 0.0;
  bool is_clock = false;
  std::size_t line = 0;
  std::int64_t series = 0;  // of which drop it is, where the table says so
};

/// The times or intervals of a table in their order, not yet in seconds.
struct Sequence {
  std::vector<Found> values;
  std::string from;   ///< which column or row
  std::string title;  ///< says a unit, perhaps
  bool says_intervals = false, says_times = false;
  bool has_series = false;
  std::size_t n_left_out = 0;  ///< rows of means
};

/// One drop in each row: "Start (s)", "Stop 1 (s)", "Stop 2 (s)" ..., or a single row of numbers.
/// @return nothing of another table @throws FileError where it is not clear which a drop is, a row or a column
std::optional<Sequence> rows_of_values(const ForeignTable& table, const std::string& name);
/// Those of one column, and of which drop they are by others. @throws FileError where there is none, or one a drop
Sequence column_of_values(const ForeignTable& table, const ForeignOptions& options, const std::string& name);

}  // namespace bouncelab
