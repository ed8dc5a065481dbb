// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstring>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/vector_clones.hpp"
#include "law/law_block.hpp"

namespace bouncelab::fit {
namespace {

double sum_of(const std::array<double, kLanes>& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

BOUNCELAB_VECTOR_CLONES void sum_of_products(std::size_t n, const double* a, const double* b, double* lanes) {
  std::array<double, kLanes> sum;
  for (std::size_t l = 0; l < kLanes; ++l) sum[l] = lanes[l];
  std::size_t k = 0;
  for (; k + kLanes <= n; k += kLanes)
    for (std::size_t l = 0; l < kLanes; ++l) sum[l] += a[k + l] * b[k + l];
  for (std::size_t l = 0; k < n; ++k, ++l) sum[l] += a[k] * b[k];
  for (std::size_t l = 0; l < kLanes; ++l) lanes[l] = sum[l];
}

constexpr std::size_t kPowersAtOnce = 3;

/// Adds a x^j, j < n_powers, to sums whose lanes follow each other. @param next  a x^n_powers, may be in a's place
template <std::size_t n_powers>
[[gnu::always_inline]] inline void sum_powers(std::size_t n, const double* a, const double* x, double* next,
                                              double* lanes) {
  std::array<Lanes, n_powers> sum;
  std::memcpy(sum.data(), lanes, sizeof sum);
  std::size_t k = 0;
  for (; k + kLanes <= n; k += kLanes) {
    Lanes term, factor;
    std::memcpy(&term, a + k, sizeof term);
    std::memcpy(&factor, x + k, sizeof factor);
    for (std::size_t j = 0; j < n_powers; ++j, term *= factor) sum[j] += term;
    std::memcpy(next + k, &term, sizeof term);
  }
  std::memcpy(lanes, sum.data(), sizeof sum);
  for (std::size_t l = 0; k < n; ++k, ++l) {
    double term = a[k];
    for (std::size_t j = 0; j < n_powers; ++j, term *= x[k]) lanes[j * kLanes + l] += term;
    next[k] = term;
  }
}

BOUNCELAB_VECTOR_CLONES void sum_of_one(std::size_t n, const double* a, const double* x, double* next, double* lanes) {
  sum_powers<1>(n, a, x, next, lanes);
}
BOUNCELAB_VECTOR_CLONES void sum_of_some(std::size_t n, const double* a, const double* x, double* next, double* lanes) {
  sum_powers<kPowersAtOnce>(n, a, x, next, lanes);
}

/// Whether all lie where a product of kBlockSize / kLanes of them is a number.
BOUNCELAB_VECTOR_CLONES bool are_moderate(std::size_t n, const double* x) {
  constexpr double kLeast = 1e-30, kMost = 1e30;
  std::size_t n_moderate = 0;
  for (std::size_t k = 0; k < n; ++k) n_moderate += (x[k] > kLeast) & (x[k] < kMost);
  return n_moderate == n;
}

BOUNCELAB_VECTOR_CLONES void add_and_multiply(std::size_t n, const double* terms, const double* factors, double* sums,
                                              double* products) {
  std::size_t k = 0;
  for (; k + kLanes <= n; k += kLanes)
    for (std::size_t l = 0; l < kLanes; ++l) {
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
  if (are_moderate(n, f.factor.data())) {
    add_and_multiply(n, f.exponent.data(), f.factor.data(), sum_.data(), product_.data());
  } else {
    Block logarithms = f.factor;
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
  Block next;
  const double* of = a;
  for (std::size_t j = 0; j < n_powers; of = next.data()) {
    const bool some = j + kPowersAtOnce <= n_powers;
    (some ? sum_of_some : sum_of_one)(n, of, x, next.data(), sums_[i + j].data());
    j += some ? kPowersAtOnce : 1;
  }
}

void GradientSum::put(double* sums) const {
  for (std::size_t i = 0; i < sums_.size(); ++i) sums[i] = sum_of(sums_[i]);
}

}  // namespace bouncelab::fit
