// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <ostream>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"

namespace bouncelab {
namespace {

/// Splits one line into cells; a quoted cell may hold commas and doubled quotes, but no line break (no table of ours
/// needs one).
void split(std::string_view line, std::vector<std::string>& cells) {
  cells.clear();
  std::string cell;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c != '"')
        cell += c;
      else if (i + 1 < line.size() && line[i + 1] == '"')
        cell += line[++i];
      else
        quoted = false;
    } else if (c == '"' && cell.empty()) {
      quoted = true;
    } else if (c == ',') {
      cells.push_back(std::move(cell));
      cell.clear();
    } else {
      cell += c;
    }
  }
  cells.push_back(std::move(cell));
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

template <class T>
bool parse(std::string_view text, T& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size();
}

Column empty_column(const ColumnSpec& spec) {
  switch (spec.type) {
    case ColumnType::real:
      return {spec.name, std::vector<double>{}};
    case ColumnType::integer:
      return {spec.name, std::vector<std::int64_t>{}};
    case ColumnType::text:
      break;
  }
  return {spec.name, std::vector<std::string>{}};
}

/// Appends a cell; false where it does not read as the column's type.
bool append(Column& column, const std::string& cell) {
  if (auto* texts = std::get_if<std::vector<std::string>>(&column.values)) {
    texts->push_back(cell);
    return true;
  }
  const std::string_view number = trimmed(cell);
  if (auto* reals = std::get_if<std::vector<double>>(&column.values)) {
    double value = std::numeric_limits<double>::quiet_NaN();
    if (!number.empty() && !parse(number, value)) return false;
    reals->push_back(value);
    return true;
  }
  std::int64_t value = 0;
  if (!parse(number, value)) return false;
  std::get<std::vector<std::int64_t>>(column.values).push_back(value);
  return true;
}

std::string joined(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  return text;
}

bool next_line(std::istream& in, std::string& line) {
  if (!std::getline(in, line)) return false;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return true;
}

void write_text(std::ostream& out, const std::string& text) {
  if (text.find_first_of(",\"") == std::string::npos) {
    out << text;
    return;
  }
  out << '"';
  for (const char c : text) out << (c == '"' ? "\"\"" : std::string(1, c));
  out << '"';
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted)
    : name_(input_name(path)) {
  in_.open(readable(path), std::ios::binary);
  if (!in_) throw FileError(name_, "cannot be opened for reading; check its permissions");

  std::string line;
  if (!next_line(in_, line)) throw FileError(name_, "is empty; a first line naming the columns is needed");
  if (line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
  std::vector<std::string> header;
  split(line, header);
  n_cells_ = header.size();
  for (const ColumnSpec& spec : wanted) {
    const auto found =
        std::find_if(header.begin(), header.end(), [&](const std::string& cell) { return trimmed(cell) == spec.name; });
    if (found != header.end()) {
      sources_.push_back({static_cast<std::size_t>(found - header.begin()), empty_.columns.size()});
      empty_.columns.push_back(empty_column(spec));
    } else if (spec.required) {
      throw FileError(name_, "line 1: column '" + spec.name + "' is missing (found: " + joined(header) +
                                 "); the first line must name the columns");
    }
  }
}

Table CsvReader::next(std::size_t max_rows) {
  Table table = empty_;
  table.first_line = line_;
  std::string line;
  std::vector<std::string> cells;
  for (std::size_t n_rows = 0; n_rows < max_rows && next_line(in_, line); ++line_) {
    if (line.empty()) {
      table.blank_lines.push_back(line_);
      continue;
    }
    split(line, cells);
    const std::string place = "line " + std::to_string(line_);
    if (cells.size() != n_cells_)
      throw FileError(name_, place + ": " + std::to_string(cells.size()) + " cells where the header names " +
                                 std::to_string(n_cells_) + "; is the file cut off?");
    for (const Source& source : sources_)
      if (!append(table.columns[source.column], cells[source.cell]))
        throw FileError(name_, place + ", column " + table.columns[source.column].name + ": '" + cells[source.cell] +
                                   "' is not a number");
    ++n_rows;
  }
  if (in_.bad()) throw FileError(name_, "reading failed; is the disk or the network drive all right?");
  return table;
}

Table read_csv(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  return CsvReader(path, wanted).next(std::numeric_limits<std::size_t>::max());
}

void write_csv(std::ostream& out, const Table& table) {
  for (std::size_t k = 0; k < table.columns.size(); ++k) out << (k ? "," : "") << table.columns[k].name;
  out << '\n';
  write_csv_rows(out, table);
}

void write_csv_rows(std::ostream& out, const Table& table) {
  char buffer[32];
  const auto put = [&](auto value) {
    const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
    out.write(buffer, result.ptr - buffer);
  };
  for (std::size_t row = 0; row < table.n_rows(); ++row) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      if (k) out << ',';
      const auto& values = table.columns[k].values;
      if (const auto* reals = std::get_if<std::vector<double>>(&values)) {
        if (!std::isnan((*reals)[row])) put((*reals)[row]);
      } else if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&values)) {
        put((*integers)[row]);
      } else {
        write_text(out, std::get<std::vector<std::string>>(values)[row]);
      }
    }
    out << '\n';
  }
}

}  // namespace bouncelab
