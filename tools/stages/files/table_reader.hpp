// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

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

}  // namespace bouncelab::stages
