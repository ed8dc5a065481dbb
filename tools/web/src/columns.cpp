// SPDX-License-Identifier: GPL-3.0-or-later
#include "columns.hpp"

#include "bouncelab/core/error.hpp"

namespace bouncelab::web {
namespace {

using emscripten::val;

val array_of(const std::vector<std::string>& texts) {
  val list = val::array();
  for (const std::string& text : texts) list.call<void>("push", text);
  return list;
}
/// A copy that JavaScript owns.
val array_of(const std::vector<double>& values) {
  return val(emscripten::typed_memory_view(values.size(), values.data())).call<val>("slice");
}
val array_of(const std::vector<std::int64_t>& values) {
  return array_of(std::vector<double>(values.begin(), values.end()));
}

Column column_of(const val& values, const ColumnSpec& spec, const std::string& what) {
  if (spec.type == ColumnType::text) return {spec.name, emscripten::vecFromJSArray<std::string>(values)};
  const auto numbers = emscripten::convertJSArrayToNumberVector<double>(values);
  if (spec.type == ColumnType::real) return {spec.name, numbers};
  std::vector<std::int64_t> integers;
  for (const double number : numbers) {
    const std::optional<std::int64_t> integer = whole_number(number);
    if (!integer)
      throw InvalidArgument(what + ", column " + spec.name + ": " + short_number(number) + " is no integer");
    integers.push_back(*integer);
  }
  return {spec.name, integers};
}

}  // namespace

val columns_of(const Table& table) {
  val columns = val::object();
  for (const Column& column : table.columns)
    columns.set(column.name, std::visit([](const auto& values) { return array_of(values); }, column.values));
  return columns;
}

Table table_of(const val& columns, const std::vector<ColumnSpec>& wanted, const std::string& what) {
  Table table;
  std::size_t n = 0;
  for (const ColumnSpec& spec : wanted) {
    const val values = columns[spec.name];
    if (values.isUndefined()) continue;
    const auto length = values["length"].as<std::size_t>();
    if (!table.columns.empty() && length != n) throw InvalidArgument(what + ": columns of different lengths");
    n = length;
    table.columns.push_back(column_of(values, spec, what));
  }
  return table;
}

}  // namespace bouncelab::web
