// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab {

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
class CsvReader {
 public:
  CsvReader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
  /// @param in  must outlive this
  CsvReader(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted);
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;
  ~CsvReader();
  /// The next rows, at most so many; none after the last. @throws FileError
  Table next(std::size_t max_rows);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes header and rows; reals with the fewest digits that read back to the same double (at most 17), NaN as an
/// empty cell. Texts are written byte for byte; quoted where they hold commas, quotes or line breaks, or begin or end
/// with a blank.
void write_csv(std::ostream& out, const Table& table);
/// Rows only: a long table can be written in pieces.
void write_csv_rows(std::ostream& out, const Table& table);

}  // namespace bouncelab
