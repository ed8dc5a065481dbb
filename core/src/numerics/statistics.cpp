// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/numerics.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace bouncelab {

double order_statistic(std::vector<double> values, std::size_t rank) {
  assert(rank < values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double upper_median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return order_statistic(std::move(values), middle);
}

double quantile(std::span<const double> sorted, double p) {
  assert(!sorted.empty() && p >= 0.0 && p <= 1.0);
  const double at = p * (static_cast<double>(sorted.size()) - 1.0);
  const auto k = static_cast<std::size_t>(at);
  const double rest = at - static_cast<double>(k);
  return k + 1 < sorted.size() ? sorted[k] + rest * (sorted[k + 1] - sorted[k]) : sorted[k];
}

}  // namespace bouncelab
