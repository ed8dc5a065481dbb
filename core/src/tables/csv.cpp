// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <limits>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kBlock_bytes = 1 << 16;

}  // namespace

LineReader::LineReader(std::istream& in, std::string name)
    : in_(&in), name_(std::move(name)), decoder_(name_), block_(kBlock_bytes) {}

bool LineReader::fill() {
  text_.clear();
  while (text_.empty()) {
    in_->read(block_.data(), static_cast<std::streamsize>(block_.size()));
    if (in_->bad()) throw FileError(name_, "reading failed; is the disk or the network drive all right?");
    if (in_->gcount() == 0) {
      decoder_.finish();
      break;
    }
    decoder_.append({block_.data(), static_cast<std::size_t>(in_->gcount())}, text_);
  }
  at_ = text_.data();
  end_ = at_ + text_.size();
  return at_ != end_;
}

void LineReader::append(const char* end, std::string& line) {
  const auto refuse = [&](const std::string& what) {
    throw FileError(name_, "line " + std::to_string(number_) + what + "; a table of text is needed");
  };
  const auto n = static_cast<std::size_t>(end - at_);
  if (std::memchr(at_, 0, n) != nullptr) refuse(" holds a byte 0");
  if (line.size() + n > kLongestRow_bytes) refuse(" is longer than " + std::to_string(kLongestRow_bytes) + " bytes");
  line.append(at_, n);
  at_ = end;
}

bool LineReader::next(std::string& line) {
  line.clear();
  if (at_ == end_ && !fill()) return false;
  ++number_;
  do {
    const auto* found = static_cast<const char*>(std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_)));
    append(found != nullptr ? found : end_, line);
    if (found == nullptr) continue;
    ++at_;
    return true;
  } while (fill());
  return true;
}

std::ifstream open_text(const std::filesystem::path& path) {
  std::ifstream in(readable(path), std::ios::binary);
  if (!in) throw FileError(input_name(path), "cannot be opened for reading; check its permissions");
  return in;
}

namespace {

/// Splits the lines of a CSV file into rows of cells.
class CsvRows {
 public:
  explicit CsvRows(LineReader lines) : lines_(std::move(lines)) {}
  /// The next row that is not blank, over several lines where a quoted cell holds line breaks; false after the last.
  /// @throws FileError naming the line
  bool next(std::vector<std::string>& cells) {
    do
      if (!lines_.next(text_)) return false;
    while (text_.empty() || text_ == "\r");
    line_ = lines_.number();
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
  /// On which the row begins, counted from 1.
  std::size_t line() const { return line_; }
  const std::string& name() const { return lines_.name(); }

 private:
  enum class State { begin_of_cell, bare, quoted, after_quote };

  /// Takes what belongs together and says how many bytes that were.
  std::size_t take(std::string_view text, std::vector<std::string>& cells) {
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

  void split(std::string_view text, std::vector<std::string>& cells) {
    const bool has_return = !text.empty() && text.back() == '\r';
    if (has_return) text.remove_suffix(1);
    while (!text.empty()) text.remove_prefix(take(text, cells));
    if (state_ == State::quoted) cells.back() += has_return ? "\r\n" : "\n";
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw FileError(name(), "line " + std::to_string(lines_.number()) + ": " + what);
  }

  LineReader lines_;
  std::string text_;
  State state_ = State::begin_of_cell;
  std::size_t line_ = 0;
};

/// What is wrong with a cell; nullptr: nothing.
using Fault = const char*;

Fault append(std::vector<std::string>& texts, const std::string& cell) {
  texts.push_back(cell);
  return nullptr;
}

Fault append(std::vector<double>& reals, const std::string& cell) {
  const std::string_view number = trimmed(cell);
  double value = std::numeric_limits<double>::quiet_NaN();
  const std::errc status = number.empty() ? std::errc{} : parse_number(number, value);
  if (status == std::errc::result_out_of_range) return "is beyond the range of a 64-bit real";
  if (status != std::errc{}) return "is not a number";
  reals.push_back(value);
  return nullptr;
}

Fault append(std::vector<std::int64_t>& integers, const std::string& cell) {
  const std::string_view number = trimmed(cell);
  std::int64_t value = 0;
  std::errc status = parse_number(number, value);
  if (status == std::errc::invalid_argument) {
    double real = 0.0;
    if (parse_number(number, real) != std::errc{}) return "is not a number";
    const auto whole = whole_number(real);
    if (!whole) return "is not an integer";
    value = *whole;
    status = {};
  }
  if (status != std::errc{}) return "is beyond the range of a 64-bit integer";
  integers.push_back(value);
  return nullptr;
}

/// Digits behind the point; of a number with a power of ten very many.
int decimals_of(std::string_view number) {
  if (number.find_first_of("eEnN") != std::string_view::npos) return number.empty() ? -1 : 100;
  const auto point = number.find('.');
  return point == std::string_view::npos ? 0 : static_cast<int>(number.size() - point - 1);
}

std::string joined(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  return text;
}

}  // namespace

struct TableReader::State {
  struct Source {
    std::size_t cell, column;  // position in the line and in the table
  };
  std::shared_ptr<std::istream> in;
  CsvRows rows;
  Table empty;
  std::vector<Source> sources;
  std::size_t n_cells = 0;

  State(std::shared_ptr<std::istream> from, const std::string& name, const std::vector<ColumnSpec>& wanted)
      : in(std::move(from)), rows(LineReader(*in, name)) {
    read_header(wanted);
  }

  void read_header(const std::vector<ColumnSpec>& wanted) {
    std::vector<std::string> header;
    if (!rows.next(header)) throw FileError(rows.name(), "is empty; a first line naming the columns is needed");
    n_cells = header.size();
    const std::string place = "line " + std::to_string(rows.line());
    for (const ColumnSpec& spec : wanted) {
      const auto is_wanted = [&](const std::string& cell) { return trimmed(cell) == spec.name; };
      const auto found = std::find_if(header.begin(), header.end(), is_wanted);
      if (found != header.end()) {
        sources.push_back({static_cast<std::size_t>(found - header.begin()), empty.columns.size()});
        empty.columns.push_back(empty_column(spec));
        if (std::any_of(found + 1, header.end(), is_wanted))
          throw FileError(rows.name(), place + ": column '" + spec.name + "' stands there twice; rename one of them");
      } else if (spec.required) {
        const bool is_one = header.size() == 1 && header.front().find_first_of(";\t") != std::string::npos;
        throw FileError(rows.name(), place + ": column '" + spec.name +
                                         "' is missing (found: " + printable(joined(header)) + "); " +
                                         (is_one ? "commas must separate the columns: save the table as CSV with commas"
                                                 : "the first line must name the columns"));
      }
    }
  }

  void add(const std::vector<std::string>& cells, Table& table) const {
    const std::string& name = rows.name();
    if (cells.size() != n_cells)
      throw FileError(name, "line " + std::to_string(rows.line()) + ": " + std::to_string(cells.size()) +
                                " cells where the header names " + std::to_string(n_cells) + "; is the file cut off?");
    for (const Source& source : sources) {
      const std::string& cell = cells[source.cell];
      Column& column = table.columns[source.column];
      const Fault fault = std::visit([&](auto& values) { return append(values, cell); }, column.values);
      if (fault != nullptr)
        throw FileError(name, "line " + std::to_string(rows.line()) + ", column " + column.name + ": '" +
                                  printable(cell) + "' " + fault);
      if (std::holds_alternative<std::vector<double>>(column.values) && column.decimals < 100 && !trimmed(cell).empty())
        column.decimals = std::max(column.decimals, decimals_of(trimmed(cell)));
    }
  }
};

TableReader::TableReader(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted)
    : state_(std::make_shared<State>(std::shared_ptr<std::istream>(&in, [](std::istream*) {}), name, wanted)) {}
TableReader::TableReader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted)
    : state_(std::make_shared<State>(std::make_shared<std::ifstream>(open_text(path)), input_name(path), wanted)) {}
TableReader::TableReader(Table table) : in_memory_(std::move(table)) {}

Table TableReader::next(std::size_t max_rows) {
  if (!state_) {
    Table all = in_memory_;
    for (Column& column : in_memory_.columns) std::visit([](auto& values) { values.clear(); }, column.values);
    return all;
  }
  Table table = state_->empty;
  std::vector<std::string> cells;
  for (std::size_t row = 0; row < max_rows && state_->rows.next(cells); ++row) {
    state_->add(cells, table);
    table.stands_on(row, state_->rows.line());
  }
  return table;
}

Table read_csv(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted) {
  return TableReader(in, name, wanted).next(std::numeric_limits<std::size_t>::max());
}

Table read_csv(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  return TableReader(path, wanted).next(std::numeric_limits<std::size_t>::max());
}

namespace {

void write_cell(std::string& out, std::string_view text) {
  const bool is_plain = text.find_first_of(",\"\r\n") == std::string_view::npos && trimmed(text) == text;
  if (is_plain) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

template <class Number>
requires std::is_arithmetic_v<Number>
void write_cell(std::string& out, Number value) {
  char buffer[32];
  out.append(buffer, bouncelab::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

bool is_unknown(double value) { return std::isnan(value); }
bool is_unknown(std::int64_t) { return false; }
bool is_unknown(const std::string& text) { return text.empty(); }

}  // namespace

void write_csv(std::ostream& out, const Table& table) {
  std::string header;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (k) header += ',';
    write_cell(header, table.columns[k].name);
  }
  out << header << '\n';
  write_csv_rows(out, table);
}

void write_csv_rows(std::ostream& out, const Table& table) {
  constexpr std::size_t kPiece = 65536;  // bytes: a stream takes longer for a cell than its digits do
  // alone in its row an empty cell would be a blank line, which is skipped on reading
  const std::string_view unknown = table.columns.size() == 1 ? "\"\"" : "";
  std::string text;
  for (std::size_t row = 0; row < table.n_rows(); ++row) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      if (k) text += ',';
      std::visit(
          [&](const auto& values) {
            if (is_unknown(values[row]))
              text += unknown;
            else
              write_cell(text, values[row]);
          },
          table.columns[k].values);
    }
    text += '\n';
    if (text.size() < kPiece) continue;
    out << text;
    text.clear();
  }
  out << text;
}

}  // namespace bouncelab
