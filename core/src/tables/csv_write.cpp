// SPDX-License-Identifier: GPL-3.0-or-later
#include <charconv>
#include <cmath>
#include <ostream>
#include <string>
#include <string_view>

#include "bouncelab/core/csv.hpp"

namespace bouncelab {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

bool needs_quotes(std::string_view text) {
  return text.find_first_of(",\"\r\n") != std::string_view::npos ||
         (!text.empty() && (is_blank(text.front()) || is_blank(text.back())));
}

void write_cell(std::string& out, std::string_view text) {
  if (!needs_quotes(text)) {
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

/// Cells of rows as text.
struct Writer {
  std::string& out;
  bool alone;  // in its row: an empty cell would be a blank line, which is skipped on reading

  template <class T>
  void number(T value) {
    char buffer[32];
    const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
    out.append(buffer, result.ptr);
  }
  void nothing() {
    if (alone) out += "\"\"";
  }
  void cell(double value) {
    if (std::isnan(value))
      nothing();
    else
      number(value);
  }
  void cell(std::int64_t value) { number(value); }
  void cell(const std::string& text) {
    if (text.empty())
      nothing();
    else
      write_cell(out, text);
  }
};

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
  std::string text;
  Writer writer{text, table.columns.size() == 1};
  for (std::size_t row = 0; row < table.n_rows(); ++row) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      if (k) text += ',';
      std::visit([&](const auto& values) { writer.cell(values[row]); }, table.columns[k].values);
    }
    text += '\n';
    if (text.size() < kPiece) continue;
    out << text;
    text.clear();
  }
  out << text;
}

}  // namespace bouncelab
