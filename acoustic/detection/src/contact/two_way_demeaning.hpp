// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

namespace bouncelab::detection {

/// Values by impact (row) and band (column).
class BandTable {
 public:
  BandTable() = default;
  BandTable(std::size_t n_impacts, std::size_t n_bands, double value = 0.0)
      : n_bands_(n_bands), values_(n_impacts * n_bands, value) {}
  bool empty() const { return values_.empty(); }
  std::size_t n_impacts() const { return values_.size() / n_bands_; }
  std::size_t n_bands() const { return n_bands_; }
  double* operator[](std::size_t k) { return values_.data() + k * n_bands_; }
  const double* operator[](std::size_t k) const { return values_.data() + k * n_bands_; }

 private:
  std::size_t n_bands_ = 1;
  std::vector<double> values_;
};

std::vector<double> sums_of_rows(const BandTable& x);
std::vector<double> sums_of_columns(const BandTable& x);

/// Weighted two-way demeaning: subtracts weighted means of rows and of columns in turns, until those of the columns
/// have fallen to 1e-4 of the first, at most twelve times. What is left is orthogonal to row and column effects (the
/// within transformation of a two-way fixed-effects regression).
/// @param weight  of the size of x, not negative
void demean_two_way(BandTable& x, const BandTable& weight);

}  // namespace bouncelab::detection
