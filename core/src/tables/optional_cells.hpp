// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace bouncelab {

/// "Not known" is an absent optional in a value and an empty cell (NaN) in a table.
inline double cell_of(const std::optional<double>& value) {
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

inline std::optional<double> optional_cell(const std::vector<double>* column, std::size_t row) {
  if (column == nullptr || std::isnan((*column)[row])) return std::nullopt;
  return (*column)[row];
}

}  // namespace bouncelab
