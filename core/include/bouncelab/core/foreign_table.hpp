// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/description.hpp"
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
  bool is_clock = false;  ///< was H:M:S or M:S, and is in seconds
};
/// A finite number: "0.5", "5,0E-1" with a decimal comma, "00:00:00.500".
std::optional<NumberCell> number_of(std::string_view cell, char decimal);

/// The format in which all cells of a line that are not empty are numbers, at least one; nothing where there is none.
std::optional<CellFormat> format_of(std::string_view line);

/// "0,0021" and nothing else: one number or two.
bool is_ambiguous(std::string_view line, const CellFormat& format);

/// The unit of time that a title names [s]: "Time (ms)", "t_us", "seconds"; nothing where it names none.
std::optional<double> time_unit_s(std::string_view title);
/// Whether a title says time, in one of several languages, or names a unit of time.
bool is_time_title(std::string_view title);

/// A table that another program or a person wrote: rows of cells, as far as they hold numbers.
struct ForeignTable {
  struct Row {
    std::size_t line = 0;  ///< of the file, from 1
    char decimal = '.';
    std::vector<std::string> cells;
    /// That of a cell, where it is one.
    std::optional<NumberCell> number(std::size_t column) const { return number_of(cells[column], decimal); }
  };
  CellFormat format;
  std::vector<std::string> titles;  ///< of the columns; empty where no line names them
  std::vector<Row> rows;            ///< those with a number, each of titles.size() or more cells
  std::size_t n_left_out = 0;       ///< lines behind the first row that hold no number
  std::size_t first_left_out = 0;   ///< the first of them

  std::size_t n_columns() const { return rows.empty() ? 0 : rows.front().cells.size(); }
};

/// Separator and decimal sign are those by which the most rows have numbers.
/// @param text  UTF-8 (decoded_text)
/// @throws FileError: no line holds a number, one number or two ("0,0021"), more than 1,024 columns
ForeignTable read_foreign_table(std::string_view text, const std::string& name);

/// What a reader is told of a file that is not ours. "auto", empty: found from the file.
struct ForeignOptions {
  std::string as = "auto";    ///< or "times", "intervals"
  std::string unit = "auto";  ///< or "s", "ms", "us"
  std::string columns;        ///< "v=speed,eps=e": which of its columns, by title or by number from 1

  bool tells() const { return as != "auto" || unit != "auto" || !columns.empty(); }
};

/// A table of ours made of one that is not.
struct TakenTable {
  Table table;
  std::string taken_for;  ///< what it was taken for, in a few words for people
};

/// Impact times, or the intervals between them, as the table of onsets that onsets_from_table reads. Columns are chosen
/// by their titles, else by their numbers; a row of at least three is read like a column. Where no column tells the
/// drops apart, one begins where times go back, an interval is kMissed times as long as either of the two before it (of
/// times), or an interval grows by half (of intervals).
/// @throws FileError with the remedy: no column of times, a unit that cannot be told, times that are equally spaced as
///         a video's are
TakenTable onsets_from_foreign(const ForeignTable& table, const std::string& name, const ForeignOptions& options);

/// Of several drops in a row a new one begins where an interval is so many times either of the two before it: with one
/// impact missed it is 1 + eps times, with two 1 + eps + eps^2, which is below 3.
inline constexpr double kMissed = 3.0;
/// The drop of each time, from 0: a new one begins where times go back or an interval is kMissed times either of
/// the two before it, of which a mark too many makes one short.
std::vector<std::int64_t> drops_of(std::span<const double> t_s);

/// Speeds and coefficients of restitution that others measured, as the table that samples_from_table reads.
/// @throws FileError with the remedy: columns that cannot be told
TakenTable samples_from_foreign(const ForeignTable& table, const std::string& name, const ForeignOptions& options);

/// Where its times are equally spaced, at least eight of two or more columns, their step [s]: samples of a sound,
/// frames of a video.
std::optional<double> uniform_step_s(const ForeignTable& table);

}  // namespace bouncelab
