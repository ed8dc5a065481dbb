// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab::fuzz {

/// Columns of equal length, of the types wanted, the required ones among them.
void check_columns(const Table& table, const std::vector<ColumnSpec>& wanted);

/// The same columns with the same cells, bit for bit but for which NaN it is.
bool are_same(const Table& a, const Table& b);

/// A format of tables, with the input to be read bound.
struct TableFormat {
  std::function<Table(const std::vector<ColumnSpec>&)> read;
  /// Reads what it wrote of a table.
  std::function<Table(const Table&, const std::vector<ColumnSpec>&)> read_back;
};

/// Reads the input as each of the tables impacts, onsets and samples, and checks of those that are accepted: columns,
/// values in the ranges promised, and that both tables and values are the same when written and read again.
void check_tables(const TableFormat& format);

}  // namespace bouncelab::fuzz
