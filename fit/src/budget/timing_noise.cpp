// SPDX-License-Identifier: GPL-3.0-or-later
#include "budget/timing_noise.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"

namespace bouncelab::fit {
namespace {

/// Two neighbouring impacts of a drop.
struct Pair {
  double product_s2;  ///< -r r' T T' / ((1+e)(1+e'))
  double normalised;  ///< r r' / (spread spread')
  std::size_t group;  ///< drop
};

std::vector<Pair> pairs_of(const RestitutionSamples& samples, const std::vector<double>& residuals) {
  std::vector<Pair> pairs;
  std::size_t drop = 0;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const RestitutionSample &a = samples[k], &b = samples[k + 1];
    if (a.recording != b.recording || a.drop != b.drop) {
      ++drop;
      continue;
    }
    const double interval_s = b.t_s - a.t_s;  // T_{i+1}
    if (b.impact != a.impact + 1 || !(interval_s > 0.0) || !(a.eps > 0.0)) continue;
    const double before_s = interval_s / a.eps;
    const double ra = residuals[k], rb = residuals[k + 1];
    // every spread of eps goes nearly as 1/T: that makes the pairs alike
    pairs.push_back(
        {-ra * rb * interval_s * before_s / ((1.0 + a.eps) * (1.0 + b.eps)), ra * before_s * rb * interval_s, drop});
  }
  return pairs;
}

struct MeanWithError {
  double mean, se;
};

/// Mean over pairs; error from the sums of the drops, or of pairs where there are few drops.
MeanWithError mean_by_drop(const std::vector<Pair>& pairs, double Pair::*member) {
  constexpr std::size_t kEnoughDrops = 8;
  const auto n = static_cast<double>(pairs.size());
  double mean = 0.0;
  for (const Pair& p : pairs) mean += p.*member / n;
  const std::size_t n_drops = pairs.back().group + 1;
  const bool by_drop = n_drops >= kEnoughDrops;
  std::vector<double> sums(by_drop ? n_drops : pairs.size(), 0.0);
  for (std::size_t k = 0; k < pairs.size(); ++k) sums[by_drop ? pairs[k].group : k] += pairs[k].*member - mean;
  double variance = 0.0;
  for (const double s : sums) variance += s * s;
  return {mean, std::sqrt(variance) / n};
}

std::optional<double> stated_timing_s(const RestitutionSamples& samples) {
  std::vector<double> stated;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    const double interval_s = samples[k + 1].t_s - s.t_s;
    if (!s.sigma_eps || samples[k + 1].drop != s.drop || samples[k + 1].impact != s.impact + 1 || !(interval_s > 0.0))
      continue;
    const double of_times = std::sqrt(1.0 + (1.0 + s.eps) * (1.0 + s.eps) + s.eps * s.eps);
    stated.push_back(*s.sigma_eps * (interval_s / s.eps) / of_times);
  }
  if (stated.empty()) return std::nullopt;
  return upper_median(stated);
}

}  // namespace

std::optional<TimingNoise> timing_noise(const RestitutionSamples& samples, const std::vector<double>& residuals) {
  const auto pairs = pairs_of(samples, residuals);
  if (pairs.size() < 8) return std::nullopt;
  const MeanWithError variance = mean_by_drop(pairs, &Pair::product_s2);
  const MeanWithError covariance = mean_by_drop(pairs, &Pair::normalised);
  double squares = 0.0;
  std::size_t n = 0;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const double interval_s = samples[k + 1].t_s - samples[k].t_s;
    if (samples[k + 1].drop != samples[k].drop || samples[k + 1].impact != samples[k].impact + 1 || !(interval_s > 0.0))
      continue;
    squares += square(residuals[k] * interval_s / samples[k].eps);
    ++n;
  }
  TimingNoise noise;
  noise.n_pairs = pairs.size();
  noise.lag1_correlation = covariance.mean / (squares / static_cast<double>(n));
  noise.lag1_correlation_se = covariance.se / (squares / static_cast<double>(n));
  noise.variance_s2 = variance.mean;
  noise.variance_se_s2 = variance.se;
  if (variance.mean > 0.0) noise.sigma_s = std::sqrt(variance.mean);
  noise.upper95_s = std::sqrt(std::max(0.0, variance.mean) + 1.645 * variance.se);
  noise.stated_s = stated_timing_s(samples);
  return noise;
}

}  // namespace bouncelab::fit
