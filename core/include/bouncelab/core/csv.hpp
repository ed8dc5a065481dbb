// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iosfwd>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// Reads the columns wanted from a CSV file: one header line, comma, '.', quotes as in RFC 4180, CRLF or LF, a byte
/// order mark is skipped. Other columns are passed over. Columns come in the order of `wanted`.
/// @throws FileError naming line and column: file missing or empty, a required column absent, a row of another length,
///         a cell that is not a number (an empty cell of a real column is NaN; of an integer column an error)
Table read_csv(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);

/// As read_csv, a piece of the file at a time: tables longer than the memory.
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
  /// The next rows, at most so many; none after the last. @throws FileError
  Table next(std::size_t max_rows);

 private:
  struct Source {
    std::size_t cell, column;  // position in the line and in the table
  };
  std::string name_;
  std::ifstream in_;
  Table empty_;
  std::vector<Source> sources_;
  std::size_t n_cells_ = 0;
  std::size_t line_ = 2;  // that the next row is looked for on
};

/// Writes header and rows; reals with the fewest digits that read back to the same double (at most 17), NaN as an
/// empty cell.
void write_csv(std::ostream& out, const Table& table);
/// Rows only: a long table can be written in pieces.
void write_csv_rows(std::ostream& out, const Table& table);

}  // namespace bouncelab
