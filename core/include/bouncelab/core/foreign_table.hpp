// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// How a table of text writes its cells.
struct CellFormat {
  char separator = ',';  ///< ' ': any number of blanks
  char decimal = '.';
};

/// Cells without blanks and quotes around them. A separator within quotes is part of the cell.
std::vector<std::string_view> cells_of(std::string_view line, char separator);

struct NumberCell {
  double value = 0.0;
  double rounding = 0.0;  ///< half a unit of the last digit
  bool is_clock = false;  ///< the cell was H:M:S, M:S, or a date and time (ISO 8601); the value is in seconds
};
/// A finite number: "0.5", "5,0E-1" with a decimal comma, "00:00:00.500", "2026-11-28T10:00:00.5+01:00".
std::optional<NumberCell> number_of(std::string_view cell, char decimal);

/// The formats in which every cell of a line is a number or empty, at least one of them a number. Several where "0,5"
/// may be one number or two; none where the line holds a word.
std::vector<CellFormat> formats_of(std::string_view line);

enum class Dimension { time, length, speed };

/// A unit, and the quantity that a title names beside it.
struct TitleUnit {
  Dimension dimension = Dimension::time;
  double si = 1.0;  ///< in s, m or m/s
  std::string name, quantity;
};
/// The whole unit in "Time (s)", "t [ms]", "time / s", "time_ms", "v (m/s)"; absent where a title names none:
/// "Time (10^-3 s)", "T^2 (s^2)", "Time".
std::optional<TitleUnit> unit_of_title(std::string_view title);

/// What a reader is told of a file that is not ours. "auto", empty: the file has to prove it.
struct ForeignOptions {
  std::string as = "auto";    ///< or "times", "intervals", "heights"
  std::string unit = "auto";  ///< or "s", "ms", "us"; "m", "cm", "mm", "in", "ft" of heights
  std::string columns;        ///< "t=Time (s),drop=2", "v=speed,eps=e": columns by title or by number from 1

  bool tells() const { return as != "auto" || unit != "auto" || !columns.empty(); }
  /// Columns of speeds or of coefficients of restitution.
  bool tells_speeds() const;
};

/// A table that another program or a person wrote.
struct ForeignTable {
  struct Row {
    std::size_t line = 0;  ///< of the file, from 1
    bool follows_blank = false;
    std::vector<std::string> cells;  ///< as many as the table has columns
  };
  std::string name;  ///< of the file, for messages
  ForeignOptions options;
  CellFormat format;
  std::vector<std::string> titles;  ///< of the columns; empty where no line names them
  std::vector<Row> rows;            ///< at least one

  std::size_t n_columns() const { return rows.front().cells.size(); }
  std::optional<NumberCell> number(const Row& row, std::size_t column) const {
    return number_of(row.cells[column], format.decimal);
  }
  /// @throws FileError
  [[noreturn]] void refuse(const std::string& what) const { throw FileError(name, what); }
};

/// A table that does not prove what its numbers are. Exit code 2, as of an argument that is missing.
class AmbiguousTable : public InvalidArgument {
 public:
  struct Column {
    std::string title, first_cells;  ///< its title or number; its first three cells
  };
  struct Reading {
    std::string meaning;  ///< "intervals in s"
    ForeignOptions options;
  };
  AmbiguousTable(const std::string& file, const std::string& question, std::vector<Column> columns,
                 std::vector<Reading> readings);
  /// With the file's name, without the readings, which what() has too.
  const std::string& question() const { return question_; }
  const std::vector<Column>& columns() const { return columns_; }
  const std::vector<Reading>& readings() const { return readings_; }

 private:
  std::string question_;
  std::vector<Column> columns_;
  std::vector<Reading> readings_;
};
/// As on a command line: --as intervals --columns 't=Time (s)'.
std::string command_line_of(const ForeignOptions& options);

/// The cells of a table. The line above the first row of numbers names the columns, and settles by what stands between
/// its titles (tab, ; or ,; else blanks) the separator of all rows; the lines above that line are passed over. Without
/// titles the separator is the one by which all rows have the same number of cells, all of them numbers. The decimal
/// sign is a comma where a cell needs one. Lines that begin with # are comments as far as the titles, not below.
/// @param text     UTF-8 (decoded_text)
/// @param options  of two readings of "0,5" without titles, --as takes one number and --columns two
/// @throws FileError: no line holds a number, a row of another length, more than 1,024 columns
/// @throws AmbiguousTable: one number or two ("0,0021")
ForeignTable read_foreign_table(std::string_view text, const std::string& name, const ForeignOptions& options = {});

/// A table of ours made of one that is not.
struct TakenTable {
  Table table;
  std::string taken_for;  ///< what it was taken for, in a few words for people
};

/// Impact times, the intervals between them, or heights, as the table of onsets that onsets_from_table reads; the rule
/// is in docs/formats.md, "Files of other programs".
/// @throws FileError: a cell that is not a number, a gap, a time that stands twice
/// @throws AmbiguousTable: what the numbers are, or which of them, is not proved
TakenTable onsets_from_foreign(const ForeignTable& table);

/// Of several drops in a row a new one begins where an interval is so many times either of the two before it: with one
/// impact missed it is 1 + eps times, with two 1 + eps + eps^2, which is below 3.
inline constexpr double kMissed = 3.0;
/// Nor does a ball fly so long: at 49 m/s here, at 8 m/s on the Moon.
inline constexpr double kLongestFlight_s = 10.0;
/// The drop of each time, from 0: a new one begins where times go back, where an interval is longer than any flight, or
/// kMissed times either of the two before it, of which a mark too many makes one short.
std::vector<std::int64_t> drops_of(std::span<const double> t_s);

/// Whether the columns that are told, else the units of the titles, are of speeds and of no time or length.
bool holds_speeds(const ForeignTable& table);
/// Speeds and coefficients of restitution that others measured, or speeds before and after, as the table that
/// samples_from_table reads.
/// @throws FileError: a cell that is not a number, a unit that is not of a speed, coefficients per cent
/// @throws AmbiguousTable: no columns v_mps and eps, and none named
TakenTable samples_from_foreign(const ForeignTable& table);

}  // namespace bouncelab
