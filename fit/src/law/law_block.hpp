// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "law/normal_laplace_block.hpp"

namespace bouncelab::fit {

inline constexpr std::size_t kMostLawParameters = 8;  ///< orders 2, 4, 5 ... 10

/// Successive samples: what is computed of them on the way to their likelihood.
struct SampleBlock {
  std::size_t begin = 0, n = 0;
  Block residual;                               ///< from the curve
  std::array<Block, kMostLawParameters> slope;  ///< of the curve by q
  SidesBlock sides;
  // of the scatter with a normal part
  Block tau, inverse_tau, normal_share, size;
  Block peak, peak_by_asymmetry, peak_by_rho;  ///< in units of size
  Block width;  ///< of scatter and timing errors, where the curve is displaced by a part of it
  DensityBlock f;
};

/// Sum of log-likelihoods in lanes of their own, put together in fixed order at the end: the same for any width of
/// registers. One logarithm serves many samples: it costs as much as all else of one.
class LogSum {
 public:
  LogSum() { product_.fill(1.0); }
  void add(std::size_t n, const DensityBlock& f);
  double value() const;

 private:
  alignas(64) std::array<double, kLanes> sum_{};
  alignas(64) std::array<double, kLanes> product_;
};

/// Sums of many kinds in the same manner.
class GradientSum {
 public:
  explicit GradientSum(std::size_t n_kinds) : sums_(n_kinds, Lanes{}) {}
  /// Adds a[k] b[k] to the sum of kind i.
  void add_products(std::size_t i, std::size_t n, const double* a, const double* b);
  /// Adds a[k] x[k]^j to the sums of kinds i + j, j < n_powers.
  void add_powers(std::size_t i, std::size_t n_powers, std::size_t n, const double* a, const double* x);
  /// @param sums  n_kinds of them
  void put(double* sums) const;

 private:
  struct alignas(64) Lanes : std::array<double, kLanes> {};
  std::vector<Lanes> sums_;
};

}  // namespace bouncelab::fit
