// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/subband_errors.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "template/template_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kJitterRounds = 8;
constexpr double kLittle = 2e-3;  // relative change of each jitter; 32 impacts determine one to 12 %

/// Sum of the squared deviations, each over its expected value, and its derivative by the jitter.
struct Ratios {
  double sum = 0.0;
  double slope = 0.0;
};

/// @param squares  over the share of its variance that a deviation keeps
Ratios ratios_at(double jitter2, const std::vector<double>& squares, const std::vector<double>& noise) {
  Ratios ratios;
  for (std::size_t k = 0; k < squares.size(); ++k) {
    const double per_variance = 1.0 / (noise[k] + jitter2);
    const double ratio = squares[k] * per_variance;
    ratios.sum += std::min(ratio, kTemplate.most_of_one);
    if (ratio < kTemplate.most_of_one) ratios.slope -= ratio * per_variance;
  }
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
    const Ratios ratios = ratios_at(jitter2, squares, noise);
    (ratios.sum > n ? lo : hi) = jitter2;
    const double next = jitter2 + ratios.sum * (ratios.sum - n) / (n * -ratios.slope);
    const double last = jitter2;
    jitter2 = next > lo && next < hi ? next : 0.5 * (lo + hi);
    if (std::abs(jitter2 - last) <= kTolerance * jitter2) break;
  }
  return jitter2;
}

/// Variance of a sub-band's delay [samples^2] where that of its phase is 1.
double delay_of_phase2(const MatchedFilter& filter, const Subbands& subbands, std::size_t j) {
  return filter.energy(subbands, j) / (filter.information(subbands, j) + 1e-30);
}

/// Phases vary about alike at all frequencies: each sub-band's jitter is shrunk towards the median phase variance.
void shrink_to_median(const MatchedFilter& filter, double n_impacts, Subbands& subbands) {
  const std::size_t n = subbands.n();
  std::vector<double> phase2(n);
  for (std::size_t j = 0; j < n; ++j) phase2[j] = subbands.jitter2[j] / (delay_of_phase2(filter, subbands, j) + 1e-30);
  const double median = upper_median(phase2);
  for (std::size_t j = 0; j < n; ++j)
    subbands.jitter2[j] =
        (n_impacts * std::max(phase2[j], kTemplate.least_of_median * median) + kTemplate.prior_impacts * median) /
        (n_impacts + kTemplate.prior_impacts) * delay_of_phase2(filter, subbands, j);
}

bool have_settled(const std::vector<double>& before, const std::vector<double>& after) {
  for (std::size_t j = 0; j < after.size(); ++j)
    if (std::abs(after[j] - before[j]) > kLittle * after[j]) return false;
  return true;
}

constexpr double kMinNoise = 1e-6;  // of white noise of variance 1

struct QuietWindow {
  double weighted_power = 0.0;  // with the weights of the delay, over all sub-bands
  double energy = 0.0;          // sum of squares
  std::vector<double> power;    // by sub-band
};

std::vector<std::vector<float>> residuals_of(TemplateEstimation& e) {
  std::vector<std::vector<float>> residuals;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    residuals.push_back(residual_of(e, impact));
    for (float& x : residuals.back()) x /= static_cast<float>(impact.estimate.amplitude);
  }
  return residuals;
}

}  // namespace

void estimate_jitter(const std::vector<DelayEstimate>& estimates, const MatchedFilter& filter, Subbands& subbands) {
  const std::size_t n = subbands.n();
  if (estimates.size() < 3 || n < 2) return;
  for (int round = 0; round < kJitterRounds; ++round) {
    std::vector<std::vector<double>> squares(n), noise(n);  // by sub-band and impact
    for (const DelayEstimate& r : estimates) {
      const SubbandMean mean = subband_mean(subbands, r);
      for (std::size_t j = 0; j < n; ++j) {
        // over Var(d_j - mean) / Var(d_j): the mean follows each sub-band
        const double share = std::max(kTemplate.least_residual_share, 1.0 - mean.weight[j]);
        squares[j].push_back(square(r.deviation[j] - mean.deviation) / share);
        noise[j].push_back(r.noise_variance[j]);
      }
    }
    const std::vector<double> before = subbands.jitter2;
    for (std::size_t j = 0; j < n; ++j) subbands.jitter2[j] = jitter_of(squares[j], noise[j]);
    shrink_to_median(filter, static_cast<double>(estimates.size()), subbands);
    if (have_settled(before, subbands.jitter2)) break;
  }
}

double estimate_noise(TemplateEstimation& e) {
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  std::vector<QuietWindow> windows;
  std::vector<float> white(filter.n_window());
  for (const TrainingImpact& impact : e.training) {
    e.white->read(e.learned.whitener, impact.first - std::ssize(white), white);
    const audio::Spectrum spectrum = e.fourier.forward(white);
    QuietWindow& quiet = windows.emplace_back();
    quiet.energy = audio::dot(white, white);
    for (std::size_t j = 0; j < subbands.n(); ++j) {
      const double sum = filter.information_times_power_of(spectrum, subbands, j);
      quiet.power.push_back(0.5 * sum / (filter.information(subbands, j) + 1e-30));
      quiet.weighted_power += sum;
    }
  }
  const std::size_t n_quiet = (windows.size() + 1) / 2;
  // sorted, not parted: the order of the sums below would be that of one standard library
  std::sort(windows.begin(), windows.end(),
            [](const QuietWindow& a, const QuietWindow& b) { return a.weighted_power < b.weighted_power; });
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n_quiet; ++k) sum += windows[k].power[j];
    subbands.noise[j] = std::max(sum / static_cast<double>(n_quiet), kMinNoise);
  }
  double energy = 0.0;
  for (std::size_t k = 0; k < n_quiet; ++k) energy += windows[k].energy / static_cast<double>(n_quiet);
  return energy;
}

double degrees_of_freedom(const std::vector<std::vector<float>>& residuals) {
  constexpr double kFewest = 2.0;  // in phase and in quadrature
  if (residuals.size() < 2) return kFewest;
  double trace = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    trace += audio::dot(residuals[k], residuals[k]);
    for (std::size_t j = 0; j < k; ++j) squares += 2.0 * square(audio::dot(residuals[j], residuals[k]));
  }
  const auto n = static_cast<double>(residuals.size());
  trace /= n;
  squares /= n * (n - 1.0);
  const auto most = static_cast<double>(residuals.front().size());
  return squares > 0.0 ? std::clamp(trace * trace / squares, kFewest, most) : most;
}

void add_unexplained_jitter(TemplateEstimation& e, double quiet) {
  std::vector<double> unexplained;  // over what the template explains
  for (const TrainingImpact& impact : e.training) {
    const double explained = 2.0 * impact.estimate.log_likelihood_ratio;
    if (impact.is_averaged())
      unexplained.push_back(std::max(0.0, audio::dot(impact.sound, impact.sound) - explained - quiet) / explained);
  }
  if (unexplained.empty()) return;
  const double dof = degrees_of_freedom(residuals_of(e));
  const double phase2 = upper_median(std::move(unexplained)) / dof;
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  for (std::size_t j = 0; j < subbands.n(); ++j)
    subbands.jitter2[j] =
        std::max(subbands.jitter2[j], phase2 * filter.energy(subbands, j) / (filter.information(subbands, j) + 1e-30));
}

}  // namespace bouncelab::detection
