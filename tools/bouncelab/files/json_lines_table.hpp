// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <iosfwd>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab::cli {

/// Tables as JSON Lines: one object a row, its keys the columns; what is not known (NaN) is absent.

/// Reads the wanted columns; null is as absent. A column that is required must be in the first row.
/// @throws FileError naming line and key
Table read_json_lines(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);

/// Writes the rows.
void write_json_lines(std::ostream& out, const Table& table);

}  // namespace bouncelab::cli
