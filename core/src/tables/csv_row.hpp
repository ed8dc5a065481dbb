// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/line_reader.hpp"

namespace bouncelab {

/// Splits the lines of a CSV file into rows of cells.
class CsvRows {
 public:
  explicit CsvRows(LineReader lines) : lines_(std::move(lines)) {}
  /// The next row that is not blank, over several lines where a quoted cell holds line breaks; false after the last.
  /// @throws FileError naming the line
  bool next(std::vector<std::string>& cells);
  /// On which the row begins, counted from 1.
  std::size_t line() const { return line_; }
  const std::string& name() const { return lines_.name(); }

 private:
  enum class State { begin_of_cell, bare, quoted, after_quote };

  std::size_t take(std::string_view text, std::vector<std::string>& cells);
  void split(std::string_view text, std::vector<std::string>& cells);
  [[noreturn]] void refuse(const std::string& what) const;

  LineReader lines_;
  std::string text_;
  State state_ = State::begin_of_cell;
  std::size_t line_ = 0;
};

}  // namespace bouncelab
