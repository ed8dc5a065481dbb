// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/vector_clones.hpp"
#include "contact/contact_time.hpp"
#include "contact/level_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMinImpacts = 8;
constexpr std::size_t kMinBands = 6;
constexpr double kStart_s = 30e-6;           // steel on glass; the result does not depend on it
constexpr double kHalfSineOverHertz = 0.87;  // durations of pulses of about the same spectrum
constexpr double kMinTau_s = 5e-6;           // about which the law is linearised in tau^2
constexpr int kMaxSteps = 25;
constexpr int kFirstRounds = 4;  // of amplitudes and weights, which converge to a thousandth of an error
constexpr int kLaterRounds = 2;  // from those of the last step
constexpr int kPoolingRounds = 10;

/// A step of tau_1^2 and its standard error.
struct PooledEstimate {
  double step = 0.0;
  double sigma = INFINITY;
};

/// A step of tau_1^2 by each band alone, and its variance up to a common factor.
struct BandEstimates {
  std::vector<double> step;
  std::vector<double> variance;
};

/// xy += w x y, xx += w x x.
BOUNCELAB_VECTOR_CLONES void add_products(const double* w, const double* x, const double* y, double* __restrict xy,
                                          double* __restrict xx, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    xy[m] += w[m] * x[m] * y[m];
    xx[m] += w[m] * x[m] * x[m];
  }
}

/// Subtracts half of the logarithm of the variance and of the square of the residual, which is limited.
BOUNCELAB_VECTOR_CLONES void subtract_half_of(const double* log_variance, const double* residual,
                                              const double* variance, double* __restrict sum, std::size_t n) {
  constexpr double kLargest = 9.0;
  for (std::size_t m = 0; m < n; ++m) {
    const double square = residual[m] * residual[m] / variance[m];
    sum[m] -= 0.5 * (log_variance[m] + (kLargest < square ? kLargest : square));
  }
}

/// Regression of each band's residuals on d ln P / d tau_1^2, amplitudes and responses taken out of both.
BandEstimates estimates_by_band(const LevelModel& model) {
  BandTable regressor = model.dlogp_dtau2;
  BandTable rest = model.residual;
  demean_two_way(regressor, model.weight);
  demean_two_way(rest, model.weight);
  const std::size_t n = model.n_bands();
  std::vector<double> xy(n, 0.0), xx(n, 0.0);
  for (std::size_t k = 0; k < model.n_impacts(); ++k)
    add_products(model.weight[k], regressor[k], rest[k], xy.data(), xx.data(), n);
  BandEstimates estimates;
  for (std::size_t m = 0; m < n; ++m) {
    if (!model.is_active[m] || !(xx[m] > 0.0)) continue;
    estimates.step.push_back(xy[m] / xx[m]);
    estimates.variance.push_back(1.0 / xx[m]);
  }
  return estimates;
}

/// Weighted mean with Huber's factors; the scatter between bands gives the common factor of the variances.
PooledEstimate pool_bands(const BandEstimates& bands) {
  const std::vector<double>& step = bands.step;
  const std::vector<double>& variance = bands.variance;
  std::vector<double> robust(step.size(), 1.0);
  PooledEstimate mean;
  double inflation = 1.0;
  for (int round = 0; round < kPoolingRounds; ++round) {
    double sum = 0.0, weights = 0.0;
    for (std::size_t m = 0; m < step.size(); ++m)
      sum += robust[m] / variance[m] * step[m], weights += robust[m] / variance[m];
    mean.step = sum / weights;
    double chi2 = 0.0, n = 0.0;
    for (std::size_t m = 0; m < step.size(); ++m) {
      chi2 += robust[m] * square(step[m] - mean.step) / variance[m];
      n += robust[m];
    }
    inflation = std::max(1.0, chi2 / std::max(n - 2.0, 1.0));  // the amplitudes take one more degree of freedom
    mean.sigma = std::sqrt(inflation / weights);
    for (std::size_t m = 0; m < step.size(); ++m)
      robust[m] = std::min(1.0, kHuber / (std::abs(step[m] - mean.step) / std::sqrt(inflation * variance[m]) + 1e-300));
  }
  return mean;
}

/// Of normal levels, by band.
std::vector<double> log_likelihood(const LevelModel& model) {
  const std::size_t n = model.n_bands();
  std::vector<double> sums(n, 0.0), variance(n), log_variance(n);
  for (std::size_t k = 0; k < model.n_impacts(); ++k) {
    for (std::size_t m = 0; m < n; ++m) variance[m] = model.variance(k, m);
    log_variance = variance;
    log_each(log_variance);
    subtract_half_of(log_variance.data(), model.residual[k], variance.data(), sums.data(), n);
  }
  std::vector<double> by_band;
  for (std::size_t m = 0; m < n; ++m)
    if (model.is_active[m]) by_band.push_back(sums[m]);
  return by_band;
}

/// Gauss-Newton steps in tau_1^2.
/// @param tau_1_s  to start from
std::optional<ContactFit> fit_pulse(const PulseSpectrum& pulse, double tau_1_s, LevelModel& model) {
  ContactFit fit;
  for (int step = 0; step < kMaxSteps; ++step) {
    set_pulse(pulse, tau_1_s, model);
    const int n_rounds = model.is_fixed ? 1 : step == 0 ? kFirstRounds : kLaterRounds;
    for (int round = 0; round < n_rounds; ++round) {
      fit_amplitudes(model);
      update_weights(model);
    }
    const BandEstimates bands = estimates_by_band(model);
    const PooledEstimate pooled = bands.step.size() < kMinBands ? PooledEstimate{} : pool_bands(bands);
    if (!std::isfinite(pooled.step) || !std::isfinite(pooled.sigma) || !(pooled.sigma > 0.0)) return std::nullopt;
    fit = {tau_1_s * tau_1_s + pooled.step, pooled.sigma, {}};
    const double next_s = std::sqrt(std::max(fit.tau2_s2, kMinTau_s * kMinTau_s));
    if (std::abs(next_s * next_s - tau_1_s * tau_1_s) < 0.02 * pooled.sigma) break;
    tau_1_s = std::clamp(next_s, 0.6 * tau_1_s, 1.7 * tau_1_s);
  }
  fit.log_likelihood = log_likelihood(model);
  return fit;
}

}  // namespace

std::optional<ContactEvidence> fit_contact(const BandLevels& levels) {
  if (levels.contact_scaling.size() < kMinImpacts || levels.f_hz.size() < kMinBands) return std::nullopt;
  LevelModel model(levels);
  const std::optional<ContactFit> hertz = fit_pulse(PulseSpectrum::hertz(), kStart_s, model);
  if (!hertz) return std::nullopt;
  // the likelihoods of two pulses can be compared where the levels have the same bands, weights and variances
  model.is_fixed = true;
  const double start_s = kHalfSineOverHertz * std::sqrt(std::max(hertz->tau2_s2, kMinTau_s * kMinTau_s));
  const std::optional<ContactFit> half_sine = fit_pulse(PulseSpectrum::half_sine(), start_s, model);
  if (!half_sine) return std::nullopt;
  return ContactEvidence{*hertz, *half_sine};
}

}  // namespace bouncelab::detection
