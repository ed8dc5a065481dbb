// SPDX-License-Identifier: GPL-3.0-or-later
// Statistics of impacts whose drops are independent of each other, and whose impacts within a drop are not.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace bouncelab::sim::testing {

inline double mean(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double value : x) sum += value;
  return sum / static_cast<double>(x.size());
}

inline double sd(const std::vector<double>& x) {
  double sum = 0.0, sum2 = 0.0;
  for (const double value : x) {
    sum += value;
    sum2 += value * value;
  }
  const auto n = static_cast<double>(x.size());
  return std::sqrt(sum2 / n - sum / n * sum / n);
}

/// Maximum likelihood of the asymmetric Laplace density: the mode m minimises sqrt(L) + sqrt(U), L and U the sums of
/// the distances below and above it; the mean scales follow.
struct Laplace {
  double mode, below, above;
};
/// @param x  ascending
inline Laplace laplace(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  double total = 0.0;
  for (const double value : x) total += value;
  double sum_below = 0.0, best = INFINITY;
  Laplace fit{};
  for (std::size_t k = 0; k < x.size(); ++k) {
    const auto count = static_cast<double>(k);
    const double lower = count * x[k] - sum_below, upper = (total - sum_below) - (n - count) * x[k];
    if (std::sqrt(lower) + std::sqrt(upper) < best) {
      best = std::sqrt(lower) + std::sqrt(upper);
      // mean scales of the two sides: (L + sqrt(L U)) / n and (U + sqrt(L U)) / n
      const double cross = std::sqrt(lower * upper);
      fit = {x[k], (lower + cross) / n, (upper + cross) / n};
    }
    sum_below += x[k];
  }
  return fit;
}

struct Estimate {
  double value, se;
};
/// An estimate of all drops with its standard error by leaving out one group of drops at a time.
/// @param estimate  of the drops for which the argument holds
inline Estimate by_drop(std::int64_t n_groups,
                        const std::function<double(std::function<bool(std::int64_t)>)>& estimate) {
  std::vector<double> without;
  for (std::int64_t group = 0; group < n_groups; ++group)
    without.push_back(estimate([&](std::int64_t drop) { return drop % n_groups != group; }));
  return {estimate([](std::int64_t) { return true; }), sd(without) * std::sqrt(static_cast<double>(n_groups - 1))};
}

/// Kolmogorov's probability of a greater distance from the uniform distribution.
/// Source: Stephens, J. R. Stat. Soc. B 32, 115 (1970), for the factor of n.
inline double kolmogorov_p(std::vector<double> u) {
  std::sort(u.begin(), u.end());
  const auto n = static_cast<double>(u.size());
  double distance = 0.0;
  for (std::size_t k = 0; k < u.size(); ++k)
    distance = std::max({distance, static_cast<double>(k + 1) / n - u[k], u[k] - static_cast<double>(k) / n});
  const double x = distance * (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n));
  double p = 0.0;
  for (int k = 1; k < 50; ++k) p += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * x * x);
  return std::clamp(p, 0.0, 1.0);
}

}  // namespace bouncelab::sim::testing
