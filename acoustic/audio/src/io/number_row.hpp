// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bouncelab::audio {

/// How a table of text writes its cells.
struct CellFormat {
  char separator = ',';  ///< ' ': any number of blanks
  char decimal = '.';
};

/// Cells without blanks and quotes around them.
std::vector<std::string_view> cells_of(std::string_view line, char separator);

struct NumberCell {
  double value = 0.0;
  double rounding = 0.0;  ///< half a unit of the last digit
};
std::optional<NumberCell> number_of(std::string_view cell, char decimal);

/// The format in which all cells of a line that are not empty are numbers, at least one; nothing where there is none.
std::optional<CellFormat> format_of(std::string_view line);

/// "0,0021" and nothing else: one number or two.
bool is_ambiguous(std::string_view line, const CellFormat& format);

/// The unit of time that a title names [s]: "Time (ms)", "t_us", "seconds"; nothing where it names none.
std::optional<double> time_unit_s(std::string_view title);
/// Whether a title says time, in one of several languages, or names a unit of time.
bool is_time_title(std::string_view title);

}  // namespace bouncelab::audio
