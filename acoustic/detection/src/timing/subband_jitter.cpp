// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/subband_jitter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kJitterRounds = 8;
constexpr double kLittle = 2e-3;       // relative change of each jitter; 32 impacts determine one to 12 %
constexpr double kMinOfMedian = 0.5;   // least phase variance of a sub-band over the median one
constexpr double kPriorImpacts = 4.0;  // weight of the median phase variance, in impacts
constexpr double kMaxCorrelation = 0.95;

/// Sum of the squared deviations, each over its expected value, and its derivative by the jitter.
struct Ratios {
  double sum = 0.0;
  double slope = 0.0;
};

/// @param squares  over the share of its variance that a deviation keeps
BOUNCELAB_VECTOR_CLONES void add_ratios(const double* squares, const double* noise, double jitter2, std::size_t n,
                                        Ratios& ratios) {
  constexpr double kMost = 9.0;  // robust against single disturbed impacts
  constexpr std::size_t kSums = 8;
  std::array<double, kSums> sum{}, slope{};
  const auto add = [&](std::size_t k, std::size_t lane) {
    const double per_variance = 1.0 / (noise[k] + jitter2);
    const double ratio = squares[k] * per_variance;
    sum[lane] += ratio < kMost ? ratio : kMost;
    slope[lane] -= ratio < kMost ? ratio * per_variance : 0.0;
  };
  std::size_t k = 0;
  for (; k + kSums <= n; k += kSums)
    for (std::size_t lane = 0; lane < kSums; ++lane) add(k + lane, lane);
  for (; k < n; ++k) add(k, 0);
  for (std::size_t lane = 0; lane < kSums; ++lane) {
    ratios.sum += sum[lane];
    ratios.slope += slope[lane];
  }
}

Ratios ratios_at(double jitter2, const std::vector<double>& squares, const std::vector<double>& noise) {
  Ratios ratios;
  add_ratios(squares.data(), noise.data(), jitter2, squares.size(), ratios);
  return ratios;
}

/// Jitter at which the squared deviations of one sub-band, each over its expected value, average 1: by Newton's steps
/// for 1 - n / sum = 0, which is linear in the jitter where that is all there is; halved where they leave the bracket.
/// @param squares  over the share of its variance that a deviation keeps
double jitter_of(const std::vector<double>& squares, const std::vector<double>& noise) {
  constexpr double kTolerance = 1e-6;  // relative
  constexpr int kMostSteps = 60;
  const auto n = static_cast<double>(squares.size());
  if (ratios_at(0.0, squares, noise).sum <= n) return 0.0;
  double lo = 0.0;
  double hi = *std::max_element(squares.begin(), squares.end());  // at which no ratio is above 1
  double jitter2 = std::accumulate(squares.begin(), squares.end(), 0.0) / n;
  for (int step = 0; step < kMostSteps && hi - lo > kTolerance * hi; ++step) {
    const Ratios here = ratios_at(jitter2, squares, noise);
    (here.sum > n ? lo : hi) = jitter2;
    const double next = jitter2 + here.sum * (here.sum - n) / (n * -here.slope);
    const double last = jitter2;
    jitter2 = next > lo && next < hi ? next : 0.5 * (lo + hi);
    if (std::abs(jitter2 - last) <= kTolerance * jitter2) break;
  }
  return jitter2;
}

/// Deviations of each sub-band from the mean of all, by sub-band and impact.
struct Deviations {
  std::vector<std::vector<double>> deviation, noise;
  std::vector<SubbandMean> mean;
};

/// @param d  receives them; of as many sub-bands and impacts
void set_deviations(const std::vector<DelayEstimate>& estimates, const Subbands& subbands, Deviations& d) {
  const std::size_t n = subbands.n();
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    const DelayEstimate& r = estimates[k];
    d.mean[k] = subband_mean(subbands, r.noise_variance);
    double mean = 0.0;
    for (std::size_t j = 0; j < n; ++j) mean += d.mean[k].weight[j] * r.deviation[j];
    for (std::size_t j = 0; j < n; ++j) {
      d.deviation[j][k] = r.deviation[j] - mean;
      d.noise[j][k] = r.noise_variance[j];
    }
  }
}

/// Squared deviations over Var(d_j - mean) / Var(d_j): the mean follows each sub-band and, by their correlation, its
/// neighbours.
std::vector<double> squares_over_share(const Deviations& d, std::size_t subband) {
  std::vector<double> squares(d.mean.size());
  for (std::size_t k = 0; k < squares.size(); ++k) {
    const SubbandMean& m = d.mean[k];
    squares[k] =
        square(d.deviation[subband][k]) /
        std::max(kMinResidualShare, 1.0 - (2.0 * m.relative_covariance[subband] - m.design_effect) * m.weight[subband]);
  }
  return squares;
}

/// Correlation rho of the jitter of neighbours. Subtracting the mean lowers the expected product of two deviations by
/// (r_j + r_k - design effect) sqrt(w_j w_k), r the relative covariances. The estimate is shrunk by rho^2 / (rho^2 +
/// its variance), so that chance alone hardly raises it.
double correlation(const Deviations& d, const Subbands& subbands) {
  std::vector<std::vector<double>> z = d.deviation;  // in standard deviations
  for (std::size_t j = 0; j < subbands.n(); ++j)
    for (std::size_t k = 0; k < d.mean.size(); ++k)
      z[j][k] = std::clamp(z[j][k] / std::sqrt(d.noise[j][k] + subbands.jitter2[j]), -3.0, 3.0);
  double products = 0.0;
  double pairs = 0.0;
  for (std::size_t j = 0; j + 1 < subbands.n(); ++j)
    for (std::size_t k = 0; k < d.mean.size(); ++k) {
      const SubbandMean& m = d.mean[k];
      const double taken_off = (m.relative_covariance[j] + m.relative_covariance[j + 1] - m.design_effect) *
                               std::sqrt(m.weight[j] * m.weight[j + 1]);
      const double jitter2 = m.jitter[j] * m.jitter[j + 1];
      products += std::sqrt(jitter2) * (z[j][k] * z[j + 1][k] + taken_off);
      pairs += jitter2;
    }
  const double found = std::clamp(products / (pairs + 1e-30), 0.0, kMaxCorrelation);
  return found * found * found / (found * found + 1.0 / (pairs + 1e-30));
}

/// Phases vary about alike at all frequencies: each sub-band's jitter is shrunk towards the median phase variance.
void shrink_to_median(const MatchedFilter& filter, double n_impacts, Subbands& subbands) {
  const std::size_t n = subbands.n();
  const auto energy_over_information = [&](std::size_t j) {
    return filter.energy(subbands.edge[j], subbands.edge[j + 1]) /
           (filter.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30);
  };
  std::vector<double> phase2(n);
  for (std::size_t j = 0; j < n; ++j) phase2[j] = subbands.jitter2[j] / (energy_over_information(j) + 1e-30);
  const double median = upper_median(phase2);
  for (std::size_t j = 0; j < n; ++j)
    subbands.jitter2[j] = (n_impacts * std::max(phase2[j], kMinOfMedian * median) + kPriorImpacts * median) /
                          (n_impacts + kPriorImpacts) * energy_over_information(j);
}

bool have_settled(const std::vector<double>& before, const std::vector<double>& after) {
  for (std::size_t j = 0; j < after.size(); ++j)
    if (std::abs(after[j] - before[j]) > kLittle * after[j]) return false;
  return true;
}

}  // namespace

void estimate_jitter(const std::vector<DelayEstimate>& estimates, const MatchedFilter& filter, Subbands& subbands) {
  const std::size_t n = subbands.n();
  if (estimates.size() < 3 || n < 2) return;
  subbands.correlation = 0.0;
  subbands.n_training = estimates.size();
  const std::vector<std::vector<double>> zeros(n, std::vector<double>(estimates.size()));
  Deviations d{zeros, zeros, std::vector<SubbandMean>(estimates.size())};
  for (int round = 0; round < kJitterRounds; ++round) {
    set_deviations(estimates, subbands, d);
    const std::vector<double> before = subbands.jitter2;
    for (std::size_t j = 0; j < n; ++j) subbands.jitter2[j] = jitter_of(squares_over_share(d, j), d.noise[j]);
    shrink_to_median(filter, static_cast<double>(estimates.size()), subbands);
    set_deviations(estimates, subbands, d);
    subbands.correlation = correlation(d, subbands);
    if (have_settled(before, subbands.jitter2)) break;
  }
}

}  // namespace bouncelab::detection
