// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "tables/csv_row.hpp"

namespace bouncelab {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// What is wrong with a cell; nullptr: nothing.
using Fault = const char*;

template <class T>
std::errc parse(std::string_view text, T& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end != text.data() + text.size() ? std::errc::invalid_argument : status;
}

Fault append(std::vector<std::string>& texts, const std::string& cell) {
  texts.push_back(cell);
  return nullptr;
}

Fault append(std::vector<double>& reals, const std::string& cell) {
  const std::string_view number = trimmed(cell);
  double value = std::numeric_limits<double>::quiet_NaN();
  const std::errc status = number.empty() ? std::errc{} : parse(number, value);
  if (status == std::errc::result_out_of_range) return "is beyond the range of a 64-bit real";
  if (status != std::errc{}) return "is not a number";
  reals.push_back(value);
  return nullptr;
}

Fault append(std::vector<std::int64_t>& integers, const std::string& cell) {
  const std::string_view number = trimmed(cell);
  std::int64_t value = 0;
  std::errc status = parse(number, value);
  if (status == std::errc::invalid_argument) {
    double real = 0.0;
    if (parse(number, real) != std::errc{}) return "is not a number";
    const auto whole = whole_number(real);
    if (!whole) return "is not an integer";
    value = *whole;
    status = {};
  }
  if (status != std::errc{}) return "is beyond the range of a 64-bit integer";
  integers.push_back(value);
  return nullptr;
}

std::string joined(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
  return text;
}

}  // namespace

struct CsvReader::State {
  struct Source {
    std::size_t cell, column;  // position in the line and in the table
  };
  std::ifstream file;
  CsvRows rows;
  Table empty;
  std::vector<Source> sources;
  std::size_t n_cells = 0;

  State(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted) : rows(LineReader(in, name)) {
    read_header(wanted);
  }
  State(std::ifstream&& in, const std::string& name, const std::vector<ColumnSpec>& wanted)
      : file(std::move(in)), rows(LineReader(file, name)) {
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
        throw FileError(rows.name(), place + ": column '" + spec.name + "' is missing (found: " +
                                         printable(joined(header)) + "); the first line must name the columns");
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
    }
  }
};

CsvReader::CsvReader(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted)
    : state_(std::make_unique<State>(in, name, wanted)) {}
CsvReader::CsvReader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted)
    : state_(std::make_unique<State>(open_text(path), input_name(path), wanted)) {}
CsvReader::CsvReader(CsvReader&&) noexcept = default;
CsvReader& CsvReader::operator=(CsvReader&&) noexcept = default;
CsvReader::~CsvReader() = default;

Table CsvReader::next(std::size_t max_rows) {
  Table table = state_->empty;
  std::vector<std::string> cells;
  for (std::size_t row = 0; row < max_rows && state_->rows.next(cells); ++row) {
    state_->add(cells, table);
    table.stands_on(row, state_->rows.line());
  }
  return table;
}

Table read_csv(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted) {
  return CsvReader(in, name, wanted).next(std::numeric_limits<std::size_t>::max());
}

Table read_csv(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  return CsvReader(path, wanted).next(std::numeric_limits<std::size_t>::max());
}

}  // namespace bouncelab
