// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/json_lines_table.hpp"

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"

namespace bouncelab::cli {
namespace {

using Json = nlohmann::ordered_json;

Column empty_column(const ColumnSpec& spec) {
  if (spec.type == ColumnType::real) return {spec.name, std::vector<double>{}};
  if (spec.type == ColumnType::integer) return {spec.name, std::vector<std::int64_t>{}};
  return {spec.name, std::vector<std::string>{}};
}

/// Appends a value; false where it is not of the column's type. Texts and reals may be absent, integers not.
bool append(Column& column, const Json* value) {
  const bool absent = !value || value->is_null();
  if (auto* reals = std::get_if<std::vector<double>>(&column.values)) {
    if (!absent && !value->is_number()) return false;
    reals->push_back(absent ? std::numeric_limits<double>::quiet_NaN() : value->get<double>());
    return true;
  }
  if (auto* integers = std::get_if<std::vector<std::int64_t>>(&column.values)) {
    if (absent || !value->is_number_integer()) return false;
    integers->push_back(value->get<std::int64_t>());
    return true;
  }
  if (!absent && !value->is_string()) return false;
  std::get<std::vector<std::string>>(column.values).push_back(absent ? std::string() : value->get<std::string>());
  return true;
}

Json parse_row(const std::string& line, const std::string& name, const std::string& place) {
  Json row = Json::parse(line, nullptr, false);
  if (!row.is_object()) throw FileError(name, place + ": is not a JSON object; one is needed on each line");
  return row;
}

const Json* value_of(const Json& row, const std::string& key) {
  const auto found = row.find(key);
  return found == row.end() ? nullptr : &*found;
}

}  // namespace

Table read_json_lines(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted) {
  const std::string name = input_name(path);
  std::ifstream in(readable(path), std::ios::binary);
  if (!in) throw FileError(name, "cannot be opened for reading; check its permissions");
  Table table;
  bool begun = false;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string place = "line " + std::to_string(number);
    const Json row = parse_row(line, name, place);
    for (const ColumnSpec& spec : wanted) {
      if (begun || !(spec.required || row.contains(spec.name) || spec.type != ColumnType::integer)) continue;
      if (spec.required && !row.contains(spec.name))
        throw FileError(name, place + ": the key '" + spec.name + "' is missing");
      table.columns.push_back(empty_column(spec));
    }
    begun = true;
    for (Column& column : table.columns)
      if (!append(column, value_of(row, column.name)))
        throw FileError(name, place + ", key " + column.name + ": absent or not of the kind that is needed");
  }
  if (!begun) throw FileError(name, "is empty; one JSON object on each line is needed");
  return table;
}

void write_json_lines(std::ostream& out, const Table& table) {
  for (std::size_t row = 0; row < table.n_rows(); ++row) {
    Json object = Json::object();
    for (const Column& column : table.columns)
      std::visit(
          [&](const auto& values) {
            if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::vector<double>>) {
              if (std::isnan(values[row])) return;
            }
            object[column.name] = values[row];
          },
          column.values);
    out << object.dump() << '\n';
  }
}

}  // namespace bouncelab::cli
