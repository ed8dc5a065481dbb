// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/vector_clones.hpp"
#include "law/law_block.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kSumLanes = 8;

double sum_of(const std::array<double, kSumLanes>& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

BOUNCELAB_VECTOR_CLONES void sum_of_products(std::size_t n, const double* a, const double* b, double* lanes) {
  std::array<double, kSumLanes> sum;
  for (std::size_t l = 0; l < kSumLanes; ++l) sum[l] = lanes[l];
  std::size_t k = 0;
  for (; k + kSumLanes <= n; k += kSumLanes)
    for (std::size_t l = 0; l < kSumLanes; ++l) sum[l] += a[k + l] * b[k + l];
  for (std::size_t l = 0; k < n; ++k, ++l) sum[l] += a[k] * b[k];
  for (std::size_t l = 0; l < kSumLanes; ++l) lanes[l] = sum[l];
}

/// a times x in the place of a, after the sum of a.
BOUNCELAB_VECTOR_CLONES void sum_and_multiply(std::size_t n, double* a, const double* x, double* lanes) {
  std::array<double, kSumLanes> sum;
  for (std::size_t l = 0; l < kSumLanes; ++l) sum[l] = lanes[l];
  std::size_t k = 0;
  for (; k + kSumLanes <= n; k += kSumLanes)
    for (std::size_t l = 0; l < kSumLanes; ++l) {
      sum[l] += a[k + l];
      a[k + l] *= x[k + l];
    }
  for (std::size_t l = 0; k < n; ++k, ++l) {
    sum[l] += a[k];
    a[k] *= x[k];
  }
  for (std::size_t l = 0; l < kSumLanes; ++l) lanes[l] = sum[l];
}

/// Whether all lie where a product of kBlockSize / kSumLanes of them is a number.
BOUNCELAB_VECTOR_CLONES bool are_moderate(std::size_t n, const double* x) {
  constexpr double kLeast = 1e-30, kMost = 1e30;
  std::size_t n_moderate = 0;
  for (std::size_t k = 0; k < n; ++k) n_moderate += (x[k] > kLeast) & (x[k] < kMost);
  return n_moderate == n;
}

BOUNCELAB_VECTOR_CLONES void add_and_multiply(std::size_t n, const double* terms, const double* factors, double* sums,
                                              double* products) {
  std::size_t k = 0;
  for (; k + kSumLanes <= n; k += kSumLanes)
    for (std::size_t l = 0; l < kSumLanes; ++l) {
      sums[l] += terms[k + l];
      products[l] *= factors[k + l];
    }
  for (std::size_t l = 0; k < n; ++k, ++l) {
    sums[l] += terms[k];
    products[l] *= factors[k];
  }
}

}  // namespace

void LogSum::add(std::size_t n, const DensityBlock& f) {
  constexpr double kRange = 1e60;  // times that of a block's factors it is still a number
  Block logarithms = f.factor;
  if (are_moderate(n, f.factor.data())) {
    add_and_multiply(n, f.exponent.data(), f.factor.data(), sum_.data(), product_.data());
  } else {
    log_each(std::span(logarithms).first(n));
    Block ones;
    ones.fill(1.0);
    add_and_multiply(n, f.exponent.data(), ones.data(), sum_.data(), product_.data());
    add_and_multiply(n, logarithms.data(), ones.data(), sum_.data(), product_.data());
  }
  if (std::all_of(product_.begin(), product_.end(), [](double p) { return p > 1.0 / kRange && p < kRange; })) return;
  log_each(product_);
  for (std::size_t l = 0; l < kLanes; ++l) sum_[l] += product_[l];
  product_.fill(1.0);
}

double LogSum::value() const {
  std::array<double, kLanes> all = product_;
  log_each(all);
  for (std::size_t l = 0; l < kLanes; ++l) all[l] += sum_[l];
  return sum_of(all);
}

void GradientSum::add_products(std::size_t i, std::size_t n, const double* a, const double* b) {
  sum_of_products(n, a, b, sums_[i].data());
}

void GradientSum::add_powers(std::size_t i, std::size_t n_powers, std::size_t n, const double* a, const double* x) {
  Block value;
  std::copy(a, a + n, value.begin());
  for (std::size_t j = 0; j < n_powers; ++j) sum_and_multiply(n, value.data(), x, sums_[i + j].data());
}

void GradientSum::put(double* sums) const {
  for (std::size_t i = 0; i < sums_.size(); ++i) sums[i] = sum_of(sums_[i]);
}

}  // namespace bouncelab::fit
