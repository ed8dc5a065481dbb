// SPDX-License-Identifier: GPL-3.0-or-later
#include "tables/csv_row.hpp"

#include <algorithm>

#include "bouncelab/core/error.hpp"

namespace bouncelab {

void CsvRows::refuse(const std::string& what) const {
  throw FileError(name(), "line " + std::to_string(lines_.number()) + ": " + what);
}

/// Takes what belongs together and says how many bytes that were.
std::size_t CsvRows::take(std::string_view text, std::vector<std::string>& cells) {
  if (text[0] == ',' && state_ != State::quoted) {
    cells.emplace_back();
    state_ = State::begin_of_cell;
    return 1;
  }
  if (text[0] == '"' && (state_ == State::begin_of_cell || state_ == State::after_quote)) {
    if (state_ == State::after_quote) cells.back() += '"';  // a doubled one
    state_ = State::quoted;
    return 1;
  }
  if (text[0] == '"' && state_ == State::quoted) {
    state_ = State::after_quote;
    return 1;
  }
  if (state_ == State::after_quote)
    refuse("text follows the closing quote of a cell; double the quotes within a cell, as in \"12\"\" plate.wav\"");
  if (state_ == State::begin_of_cell) state_ = State::bare;
  const std::size_t n = std::min(text.find(state_ == State::quoted ? '"' : ','), text.size());
  if (state_ == State::bare && text.substr(0, n).find('\r') != std::string_view::npos)
    refuse("a carriage return outside of quotes; end the lines with LF or CRLF");
  cells.back() += text.substr(0, n);
  return n;
}

void CsvRows::split(std::string_view text, std::vector<std::string>& cells) {
  const bool has_return = !text.empty() && text.back() == '\r';
  if (has_return) text.remove_suffix(1);
  while (!text.empty()) text.remove_prefix(take(text, cells));
  if (state_ == State::quoted) cells.back() += has_return ? "\r\n" : "\n";
}

bool CsvRows::next(std::vector<std::string>& cells) {
  do
    if (!lines_.next(text_)) return false;
  while (text_.empty() || text_ == "\r");
  line_ = lines_.number();
  if (line_ == 1 && text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
  cells.assign(1, {});
  state_ = State::begin_of_cell;
  for (std::size_t size = text_.size();; size += text_.size() + 1) {
    split(text_, cells);
    if (state_ != State::quoted) return true;
    if (size > kLongestRow_bytes)
      refuse("the row that begins on line " + std::to_string(line_) + " is longer than " +
             std::to_string(kLongestRow_bytes) + " bytes; is a quote not closed?");
    if (!lines_.next(text_))
      refuse("the file ends within the quotes of a cell that the row of line " + std::to_string(line_) + " opens");
  }
}

}  // namespace bouncelab
