// SPDX-License-Identifier: GPL-3.0-or-later
/// Tables and samples of sound as NumPy arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab::python {

namespace py = pybind11;

/// An array that owns these numbers; they are not copied.
template <class Number>
py::array_t<Number> array_of(std::vector<Number>&& values, std::vector<py::ssize_t> shape = {}) {
  auto* owned = new std::vector<Number>(std::move(values));
  const py::capsule owner(owned, [](void* p) { delete static_cast<std::vector<Number>*>(p); });
  if (shape.empty()) shape = {static_cast<py::ssize_t>(owned->size())};
  return py::array_t<Number>(shape, owned->data(), owner);
}

/// Columns by name: reals and integers as arrays that own the numbers of the table, texts as arrays of str.
py::dict columns_of(Table&& table);

/// The table of the columns wanted, as far as they are there; an array of whole reals may stand for integers. Other
/// columns are left out.
/// @param what  the columns are of, for messages ("onsets")
/// @throws InvalidArgument naming the column: no numbers, more than one dimension, another length
Table table_of(const py::dict& columns, const std::vector<ColumnSpec>& wanted, const std::string& what);

/// Samples of sound of one channel, full scale = 1.
class SoundArray {
 public:
  /// @param samples  float32, contiguous: not copied; float64, or not contiguous: copied; int16 and int32: copied, full
  ///                 scale 2^15 and 2^31 as in a WAV. One dimension, or (frames, channels)
  /// @throws InvalidArgument for other types and shapes
  explicit SoundArray(const py::array& samples);

  int n_channels() const { return n_channels_; }
  /// Interleaved.
  std::span<const float> samples() const { return {samples_.data(), static_cast<std::size_t>(samples_.size())}; }

 private:
  py::array_t<float, py::array::c_style> samples_;
  int n_channels_ = 1;
};

}  // namespace bouncelab::python
