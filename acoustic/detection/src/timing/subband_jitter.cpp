// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/subband_jitter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "bouncelab/core/statistics.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kJitterRounds = 8;
constexpr double kLittle = 2e-3;       // relative change of each jitter; 32 impacts determine one to 12 %
constexpr double kMinOfMedian = 0.5;   // least phase variance of a sub-band over the median one
constexpr double kPriorImpacts = 4.0;  // weight of the median phase variance, in impacts
constexpr double kMaxCorrelation = 0.95;

/// Each squared deviation over its expected value, less the 1 that it is on average.
BOUNCELAB_VECTOR_CLONES void excesses(const double* squares, const double* noise, const double* share, double jitter2,
                                      double* __restrict excess, std::size_t n) {
  constexpr double kMost = 9.0;  // robust against single disturbed impacts
  for (std::size_t k = 0; k < n; ++k) {
    const double ratio = squares[k] / (share[k] * (noise[k] + jitter2));
    excess[k] = (ratio < kMost ? ratio : kMost) - 1.0;
  }
}

/// Jitter at which the squared deviations of one sub-band, each over its expected value, average 1; by bisection.
double jitter_of(const std::vector<double>& squares, const std::vector<double>& noise,
                 const std::vector<double>& share) {
  std::vector<double> of_each(squares.size());
  const auto excess = [&](double jitter2) {
    excesses(squares.data(), noise.data(), share.data(), jitter2, of_each.data(), of_each.size());
    return std::accumulate(of_each.begin(), of_each.end(), 0.0);
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

/// Deviations of each sub-band from the mean of all, by sub-band and impact.
struct Deviations {
  std::vector<std::vector<double>> deviation, squares, noise;
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
      d.squares[j][k] = (r.deviation[j] - mean) * (r.deviation[j] - mean);
      d.noise[j][k] = r.noise_variance[j];
    }
  }
}

/// Var(d_j - mean) / Var(d_j) for each impact: the mean follows each sub-band and, by their correlation, its
/// neighbours.
std::vector<double> residual_shares(const Deviations& d, std::size_t subband) {
  std::vector<double> shares;
  for (const SubbandMean& m : d.mean)
    shares.push_back(std::max(kMinResidualShare,
                              1.0 - (2.0 * m.relative_covariance[subband] - m.design_effect) * m.weight[subband]));
  return shares;
}

/// Correlation rho of the jitter of neighbours. Subtracting the mean lowers the expected product of two deviations by
/// (r_j + r_k - design effect) sqrt(w_j w_k), r the relative covariances. The estimate is shrunk by rho^2 / (rho^2 +
/// its variance), so that chance alone hardly raises it.
double correlation(const Deviations& d, const Subbands& subbands) {
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
  Deviations d{zeros, zeros, zeros, std::vector<SubbandMean>(estimates.size())};
  for (int round = 0; round < kJitterRounds; ++round) {
    set_deviations(estimates, subbands, d);
    const std::vector<double> before = subbands.jitter2;
    for (std::size_t j = 0; j < n; ++j)
      subbands.jitter2[j] = jitter_of(d.squares[j], d.noise[j], residual_shares(d, j));
    shrink_to_median(filter, static_cast<double>(estimates.size()), subbands);
    set_deviations(estimates, subbands, d);
    subbands.correlation = correlation(d, subbands);
    if (have_settled(before, subbands.jitter2)) break;
  }
}

}  // namespace bouncelab::detection
