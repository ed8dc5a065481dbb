// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/table.hpp"

namespace bouncelab::cli {

/// Where a table is written to, in pieces that follow one another.
class TableSink {
 public:
  TableSink() = default;
  TableSink(const TableSink&) = delete;
  TableSink& operator=(const TableSink&) = delete;
  virtual ~TableSink() = default;

  /// The next rows. @param rows  with the same columns each time. @throws FileError (disk full)
  virtual void add(const Table& rows) = 0;
  /// After the last rows. @throws FileError
  virtual void finish() = 0;
};

}  // namespace bouncelab::cli
