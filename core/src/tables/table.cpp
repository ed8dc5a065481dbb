// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"

namespace bouncelab {
namespace {

template <class T>
const std::vector<T>* values_of(const Table& table, std::string_view name) {
  for (const Column& column : table.columns)
    if (column.name == name) return std::get_if<std::vector<T>>(&column.values);
  return nullptr;
}

}  // namespace

std::size_t Table::n_rows() const {
  if (columns.empty()) return 0;
  return std::visit([](const auto& values) { return values.size(); }, columns.front().values);
}

std::size_t Table::line_of(std::size_t row) const {
  std::size_t line = first_line + row;
  for (const std::size_t blank : blank_lines) line += blank <= line ? 1 : 0;
  return line;
}

bool Table::has(std::string_view name) const {
  for (const Column& column : columns)
    if (column.name == name) return true;
  return false;
}

const std::vector<double>* Table::reals(std::string_view name) const { return values_of<double>(*this, name); }
const std::vector<std::int64_t>* Table::integers(std::string_view name) const {
  return values_of<std::int64_t>(*this, name);
}
const std::vector<std::string>* Table::texts(std::string_view name) const {
  return values_of<std::string>(*this, name);
}

}  // namespace bouncelab
