// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/subband_jitter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace bouncelab::detection {
namespace {

constexpr int kRounds = 8;
constexpr double kLeastOfTypical = 0.5;  // phase variance of the steadiest subband over that of the typical one
constexpr double kPriorImpacts = 4.0;    // impacts that the typical phase variance is worth
constexpr double kMostCorrelated = 0.95;

/// Jitter at which the squared deviations of one subband, each over its expected size, average 1.
double jitter_of(const std::vector<double>& squares, const std::vector<double>& noise,
                 const std::vector<double>& share) {
  const auto excess = [&](double jitter2) {
    double total = 0.0;
    for (std::size_t k = 0; k < squares.size(); ++k)
      total += std::min(squares[k] / (share[k] * (noise[k] + jitter2)), 9.0) - 1.0;  // a knock is no jitter
    return total;
  };
  if (excess(0.0) <= 0.0) return 0.0;
  double lo = 0.0;
  double hi = *std::max_element(squares.begin(), squares.end()) * 10.0;
  for (int step = 0; step < 60 && hi - lo > 1e-6 * hi; ++step) {
    const double middle = 0.5 * (lo + hi);
    (excess(middle) > 0.0 ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

/// Deviations of each subband from the mean of all, by subband and impact.
struct Disagreement {
  std::vector<std::vector<double>> deviation, squares, noise;
  std::vector<SubbandMean> mean;
};

Disagreement disagreement(const std::vector<DelayEstimate>& readings, const Subbands& subbands) {
  const std::size_t n = subbands.n();
  const std::vector<std::vector<double>> room(n, std::vector<double>(readings.size()));
  Disagreement d{room, room, room, {}};
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const DelayEstimate& r = readings[k];
    d.mean.push_back(subband_mean(subbands, r.noise_variance));
    double mean = 0.0;
    for (std::size_t j = 0; j < n; ++j) mean += d.mean[k].weight[j] * r.deviation[j];
    for (std::size_t j = 0; j < n; ++j) {
      d.deviation[j][k] = r.deviation[j] - mean;
      d.squares[j][k] = (r.deviation[j] - mean) * (r.deviation[j] - mean);
      d.noise[j][k] = r.noise_variance[j];
    }
  }
  return d;
}

/// Shares of its variance that a subband's deviations from the mean keep: the mean follows it, and its neighbours with
/// it.
std::vector<double> shares(const Disagreement& d, std::size_t subband) {
  std::vector<double> shares;
  for (const SubbandMean& m : d.mean)
    shares.push_back(std::max(kMinResidualShare,
                              1.0 - (2.0 * m.relative_covariance[subband] - m.design_effect) * m.weight[subband]));
  return shares;
}

/// Correlation rho of the jitter of neighbours. Taking off the mean has lowered the products of two deviations by
/// (with_j + with_k - dependence) sqrt(w_j w_k). What is found counts by rho^2 / (rho^2 + its variance): chance alone
/// hardly raises it.
double correlation(const Disagreement& d, const Subbands& subbands) {
  double products = 0.0;
  double pairs = 0.0;
  for (std::size_t j = 0; j + 1 < subbands.n(); ++j)
    for (std::size_t k = 0; k < d.mean.size(); ++k) {
      const SubbandMean& m = d.mean[k];
      const auto z = [&](std::size_t c) {
        return std::clamp(d.deviation[c][k] / std::sqrt(d.noise[c][k] + subbands.jitter2[c]), -3.0, 3.0);
      };
      const double taken_off = (m.relative_covariance[j] + m.relative_covariance[j + 1] - m.design_effect) *
                               std::sqrt(m.weight[j] * m.weight[j + 1]);
      const double jitter2 = m.jitter[j] * m.jitter[j + 1];
      products += std::sqrt(jitter2) * (z(j) * z(j + 1) + taken_off);
      pairs += jitter2;
    }
  const double found = std::clamp(products / (pairs + 1e-30), 0.0, kMostCorrelated);
  return found * found * found / (found * found + 1.0 / (pairs + 1e-30));
}

/// A mode's phase wanders about alike at all frequencies: each subband's jitter is drawn to that of the typical one.
void draw_to_typical(const MatchedFilter& wave, double n_impacts, Subbands& subbands) {
  const std::size_t n = subbands.n();
  const auto energy_over_information = [&](std::size_t j) {
    return wave.energy(subbands.edge[j], subbands.edge[j + 1]) /
           (wave.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30);
  };
  std::vector<double> phase2(n);
  for (std::size_t j = 0; j < n; ++j) phase2[j] = subbands.jitter2[j] / (energy_over_information(j) + 1e-30);
  std::vector<double> sorted = phase2;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
  const double typical = sorted[n / 2];
  for (std::size_t j = 0; j < n; ++j)
    subbands.jitter2[j] = (n_impacts * std::max(phase2[j], kLeastOfTypical * typical) + kPriorImpacts * typical) /
                          (n_impacts + kPriorImpacts) * energy_over_information(j);
}

}  // namespace

void estimate_jitter(const std::vector<DelayEstimate>& readings, const MatchedFilter& wave, Subbands& subbands) {
  const std::size_t n = subbands.n();
  if (readings.size() < 3 || n < 2) return;
  subbands.correlation = 0.0;
  subbands.n_learned = readings.size();
  for (int round = 0; round < kRounds; ++round) {
    const Disagreement d = disagreement(readings, subbands);
    for (std::size_t j = 0; j < n; ++j) subbands.jitter2[j] = jitter_of(d.squares[j], d.noise[j], shares(d, j));
    draw_to_typical(wave, static_cast<double>(readings.size()), subbands);
    subbands.correlation = correlation(disagreement(readings, subbands), subbands);
  }
}

}  // namespace bouncelab::detection
