// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/two_way_demeaning.hpp"

#include <array>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::detection {

std::vector<double> sums_of_rows(const BandTable& x) {
  const std::vector<double> ones(x.n_bands(), 1.0);
  std::vector<double> sums(x.n_impacts());
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = audio::dot(x[k], ones.data(), x.n_bands());
  return sums;
}

std::vector<double> sums_of_columns(const BandTable& x) {
  std::vector<double> sums(x.n_bands(), 0.0);
  for (std::size_t k = 0; k < x.n_impacts(); ++k) audio::add_scaled(sums.data(), 1.0, x[k], x.n_bands());
  return sums;
}

namespace {

/// One round: subtracts weighted means of rows, then of columns.
/// @param per_row, per_column  1 / sum of the weights
/// @return sum of squares of the means of columns
BOUNCELAB_VECTOR_CLONES double demean_once(double* __restrict x, const double* __restrict weight, const double* per_row,
                                           const double* per_column, double* __restrict means, std::size_t n_rows,
                                           std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) means[m] = 0.0;
  for (std::size_t k = 0; k < n_rows; ++k) {
    double* row = x + k * n;
    const double* w = weight + k * n;
    std::array<double, 8> sums{};
    std::size_t m = 0;
    for (; m + 8 <= n; m += 8)
      for (std::size_t lane = 0; lane < 8; ++lane) sums[lane] += w[m + lane] * row[m + lane];
    for (; m < n; ++m) sums[0] += w[m] * row[m];
    double mean = 0.0;
    for (const double sum : sums) mean += per_row[k] * sum;
    for (m = 0; m < n; ++m) {
      row[m] -= mean;
      means[m] += w[m] * row[m];
    }
  }
  double squares = 0.0;
  for (std::size_t m = 0; m < n; ++m) {
    means[m] *= per_column[m];
    squares += means[m] * means[m];
  }
  for (std::size_t k = 0; k < n_rows; ++k)
    for (std::size_t m = 0; m < n; ++m) x[k * n + m] -= means[m];
  return squares;
}

}  // namespace

void demean_two_way(BandTable& x, const BandTable& weight) {
  constexpr int kMaxRounds = 12;
  constexpr double kConverged = 1e-8;  // of the sum of squares of the first round
  std::vector<double> per_row = sums_of_rows(weight);
  std::vector<double> per_column = sums_of_columns(weight);
  for (double& sum : per_row) sum = 1.0 / (sum + 1e-300);
  for (double& sum : per_column) sum = 1.0 / (sum + 1e-300);
  std::vector<double> means(x.n_bands());
  double first = 0.0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double squares =
        demean_once(x[0], weight[0], per_row.data(), per_column.data(), means.data(), x.n_impacts(), x.n_bands());
    if (round == 0) first = squares;
    if (squares <= kConverged * first) break;
  }
}

}  // namespace bouncelab::detection
