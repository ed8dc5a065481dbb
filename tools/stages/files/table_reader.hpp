// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab::stages {

/// Rows that a command takes of a table at once: 128 kB of each column of numbers. More would not make anything faster,
/// and some twenty columns of it are a small part of any memory.
inline constexpr std::size_t kPiece_rows = 1 << 14;

/// A table read a piece at a time, which may be longer than the memory.
class TableReader {
 public:
  TableReader() = default;
  TableReader(const TableReader&) = delete;
  TableReader& operator=(const TableReader&) = delete;
  virtual ~TableReader() = default;

  /// The next rows, at most so many; fewer only at the end, and none after it. @throws FileError
  virtual Table next(std::size_t max_rows) = 0;
};

/// Tables as JSON Lines: one object a row, its keys the columns; what is not known (NaN) is absent.

/// Reads the wanted columns. A column is there where any row has its key; rows without it, or with null, have NaN or an
/// empty text. Integers are in all rows or in none. 3.0 is an integer too. Bytes that utf8_of_bytes() escaped are bytes
/// again. In pieces: a column is there from the first piece on in which a row has its key, a required one from the
/// first piece.
/// @throws FileError naming line and key: no text, a line longer than kLongestRow_bytes, not one JSON object, a key
///         twice, a value of another type, an integer beyond 64 bits or in some rows only, a required column in none
std::unique_ptr<TableReader> json_lines_reader(const std::filesystem::path& path,
                                               const std::vector<ColumnSpec>& wanted);
/// @param in    must outlive the reader
/// @param name  of the file, for messages
std::unique_ptr<TableReader> json_lines_reader(std::istream& in, const std::string& name,
                                               const std::vector<ColumnSpec>& wanted);

/// Writes the rows; texts by utf8_of_bytes().
void write_json_lines(std::ostream& out, const Table& table);

}  // namespace bouncelab::stages
