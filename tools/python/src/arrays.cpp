// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "bouncelab/core/error.hpp"

namespace bouncelab::python {
namespace {

/// Texts that repeat (the name of a recording in each row) are one object.
py::object array_of_texts(const std::vector<std::string>& texts) {
  py::list list(texts.size());
  py::object last;
  for (std::size_t k = 0; k < texts.size(); ++k) {
    if (k == 0 || texts[k] != texts[k - 1]) last = py::str(texts[k]);
    list[k] = last;
  }
  return py::module_::import("numpy").attr("array")(list, py::arg("dtype") = "object");
}

std::string dtype_name(const py::array& array) { return py::str(array.dtype()).cast<std::string>(); }

py::array one_dimension(const py::handle& values, const std::string& place) {
  py::array array = py::array::ensure(values);
  if (!array) {
    PyErr_Clear();
    throw InvalidArgument(place + ": not an array");
  }
  if (array.ndim() != 1)
    throw InvalidArgument(place + ": an array of " + std::to_string(array.ndim()) + " dimensions; give one of 1");
  return array;
}

template <class Number>
std::vector<Number> numbers_of(const py::array& array, const std::string& place) {
  const auto cast = py::array_t<Number, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!cast) {
    PyErr_Clear();
    throw InvalidArgument(place + ": an array of " + dtype_name(array) + ", not of numbers");
  }
  return {cast.data(), cast.data() + cast.size()};
}

std::vector<std::int64_t> integers_of(const py::array& array, const std::string& place) {
  if (array.dtype().kind() != 'f') return numbers_of<std::int64_t>(array, place);
  std::vector<std::int64_t> integers;
  for (const double value : numbers_of<double>(array, place)) {
    const std::optional<std::int64_t> integer = whole_number(value);
    if (!integer)
      throw InvalidArgument(place + ", row " + std::to_string(integers.size() + 1) + ": " + short_number(value) +
                            " is not an integer");
    integers.push_back(*integer);
  }
  return integers;
}

std::vector<std::string> texts_of(const py::handle& values, const std::string& place) {
  std::vector<std::string> texts;
  for (const py::handle text : one_dimension(values, place)) {
    const bool is_empty = text.is_none() || (py::isinstance<py::float_>(text) && std::isnan(text.cast<double>()));
    texts.push_back(is_empty ? "" : py::str(text).cast<std::string>());  // pandas has NaN for an empty cell
  }
  return texts;
}

bool is_number(char kind) { return kind == 'f' || kind == 'i' || kind == 'u' || kind == 'b'; }

Column column_of(const py::handle& values, const ColumnSpec& spec, const std::string& what) {
  const std::string place = what + ", column " + spec.name;
  if (spec.type == ColumnType::text) return {spec.name, texts_of(values, place)};
  const py::array array = one_dimension(values, place);
  if (!is_number(array.dtype().kind()))
    throw InvalidArgument(place + ": an array of " + dtype_name(array) + ", not of numbers");
  if (spec.type == ColumnType::integer) return {spec.name, integers_of(array, place)};
  return {spec.name, numbers_of<double>(array, place)};
}

/// As a WAV has integers: the greatest negative one is -1.
template <class Integer>
py::array_t<float> scaled(const py::array& samples) {
  const auto from = py::array_t<Integer, py::array::c_style | py::array::forcecast>::ensure(samples);
  py::array_t<float> to(std::vector<py::ssize_t>(from.shape(), from.shape() + from.ndim()));
  const double full_scale = -static_cast<double>(std::numeric_limits<Integer>::min());
  std::transform(from.data(), from.data() + from.size(), to.mutable_data(),
                 [full_scale](Integer sample) { return static_cast<float>(sample / full_scale); });
  return to;
}

py::array_t<float, py::array::c_style> floats_of(const py::array& samples) {
  const char kind = samples.dtype().kind();
  if (kind == 'f') return py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(samples);
  if (kind == 'i' && samples.itemsize() == 2) return scaled<std::int16_t>(samples);
  if (kind == 'i' && samples.itemsize() == 4) return scaled<std::int32_t>(samples);
  throw InvalidArgument("samples of " + dtype_name(samples) +
                        ": give float32 (or float64), full scale 1, or int16 or int32 as in a WAV");
}

}  // namespace

py::dict columns_of(Table&& table) {
  py::dict columns;
  for (Column& column : table.columns)
    if (auto* texts = std::get_if<std::vector<std::string>>(&column.values))
      columns[column.name.c_str()] = array_of_texts(*texts);
    else if (auto* reals = std::get_if<std::vector<double>>(&column.values))
      columns[column.name.c_str()] = array_of(std::move(*reals));
    else
      columns[column.name.c_str()] = array_of(std::move(std::get<std::vector<std::int64_t>>(column.values)));
  return columns;
}

Table table_of(const py::dict& columns, const std::vector<ColumnSpec>& wanted, const std::string& what) {
  Table table;
  for (const ColumnSpec& spec : wanted) {
    if (!columns.contains(spec.name)) continue;
    table.columns.push_back(column_of(columns[spec.name.c_str()], spec, what));
    if (const std::size_t n = py::len(columns[spec.name.c_str()]); n != table.n_rows())
      throw InvalidArgument(what + ": " + std::to_string(n) + " rows of " + spec.name + ", " +
                            std::to_string(table.n_rows()) + " of " + table.columns.front().name);
  }
  return table;
}

SoundArray::SoundArray(const py::array& samples) : samples_(floats_of(samples)) {
  if (samples.ndim() != 1 && samples.ndim() != 2)
    throw InvalidArgument("samples of " + std::to_string(samples.ndim()) +
                          " dimensions; give one channel, or (frames, channels)");
  if (samples.ndim() == 2) n_channels_ = static_cast<int>(samples.shape(1));
  if (n_channels_ < 1 || n_channels_ > 1024)
    throw InvalidArgument(std::to_string(n_channels_) + " channels; give samples as (frames, channels)");
  if (samples_.size() == 0) throw InvalidArgument("the sound holds no samples");
}

}  // namespace bouncelab::python
