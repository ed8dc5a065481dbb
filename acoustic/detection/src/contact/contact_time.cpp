// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/contact_time.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "contact/contact_model.hpp"
#include "contact/level_model.hpp"

namespace bouncelab::detection {
namespace {

ContactFit pool(const std::vector<ContactEvidence>& drops, ContactFit ContactEvidence::*pulse) {
  ContactFit pooled;
  double weights = 0.0;
  for (const ContactEvidence& drop : drops) {
    const ContactFit& fit = drop.*pulse;
    const double weight = 1.0 / (fit.sigma2_s2 * fit.sigma2_s2);
    weights += weight;
    pooled.tau2_s2 += weight * fit.tau2_s2;
  }
  pooled.tau2_s2 /= weights;
  double chi2 = 0.0;
  for (const ContactEvidence& drop : drops)
    chi2 += square(((drop.*pulse).tau2_s2 - pooled.tau2_s2) / (drop.*pulse).sigma2_s2);
  const double scatter = drops.size() > 1 ? std::max(1.0, chi2 / static_cast<double>(drops.size() - 1)) : 1.0;
  pooled.sigma2_s2 = std::sqrt(scatter / weights);
  return pooled;
}

/// Probability that Hertz's pulse is the more likely one, by a paired test of the log-likelihoods over bands: a band
/// that neither pulse explains counts once, whatever the number of impacts.
double probability_of_hertz(const std::vector<ContactEvidence>& drops) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const ContactEvidence& drop : drops)
    for (std::size_t m = 0; m < drop.hertz.log_likelihood.size(); ++m) {
      const double more = drop.hertz.log_likelihood[m] - drop.half_sine.log_likelihood[m];
      n += 1.0, sum += more, squares += more * more;
    }
  const double error = std::sqrt(std::max(squares - sum * sum / n, 1e-30) / (n - 1.0) * n);
  const double z = sum / error;
  return 0.5 * erfc(-std::copysign(std::max(0.0, std::abs(z) - kContact.least_pulse_difference), z) / std::sqrt(2.0));
}

/// Combined with the prior, where the two are compatible.
ContactFit with_prior(ContactFit fit, const ContactLaw& assumed) {
  const double prior = square(assumed.tau_1_s);
  const double spread = 2.0 * assumed.tau_1_s * assumed.sigma_s;
  if (std::abs(fit.tau2_s2 - prior) > kContact.most_difference * hypot(fit.sigma2_s2, spread)) return fit;
  const double weight = 1.0 / (fit.sigma2_s2 * fit.sigma2_s2);
  const double prior_weight = 1.0 / (spread * spread);
  fit.tau2_s2 = (weight * fit.tau2_s2 + prior_weight * prior) / (weight + prior_weight);
  fit.sigma2_s2 = std::sqrt(1.0 / (weight + prior_weight));
  return fit;
}

/// tau_1 from its square; 0 where that is negative.
ContactLaw law_of(const ContactFit& fit) {
  const double square = std::max(fit.tau2_s2, 0.0);
  return {std::sqrt(square), std::sqrt(square + fit.sigma2_s2) - std::sqrt(square)};
}

constexpr double kStart_s = 30e-6;  // steel on glass; the result does not depend on it
constexpr double kMinTau_s = 5e-6;  // about which the law is linearised in tau^2
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
void add_products(const double* w, const double* x, const double* y, double* __restrict xy, double* __restrict xx,
                  std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    xy[m] += w[m] * x[m] * y[m];
    xx[m] += w[m] * x[m] * x[m];
  }
}

/// Subtracts half of the logarithm of the variance and of the square of the residual, which is limited.
void subtract_half_of(const double* log_variance, const double* residual, const double* variance,
                      double* __restrict sum, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    const double square = residual[m] * residual[m] / variance[m];
    sum[m] -= 0.5 * (log_variance[m] + (kContact.most_of_residual < square ? kContact.most_of_residual : square));
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
      robust[m] =
          std::min(1.0, kContact.huber / (std::abs(step[m] - mean.step) / std::sqrt(inflation * variance[m]) + 1e-300));
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
    const PooledEstimate pooled = bands.step.size() < kContact.fewest_bands ? PooledEstimate{} : pool_bands(bands);
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

double contact_delay(double v_mps, double reference_scaling) { return 0.5 * (pow(v_mps, -0.2) - reference_scaling); }

ContactLaw assumed_contact(double rms_hz) {
  const double tau_s = kContact.duration_times_frequency / rms_hz;
  return {tau_s, kContact.duration_sigma / rms_hz, tau_s};
}

ContactLaw pool_contacts(const std::vector<ContactEvidence>& drops, const ContactLaw& assumed) {
  if (drops.empty()) return assumed;
  const ContactFit pooled[] = {pool(drops, &ContactEvidence::hertz), pool(drops, &ContactEvidence::half_sine)};
  const ContactLaw a = law_of(with_prior(pooled[0], assumed));
  const ContactLaw b = law_of(with_prior(pooled[1], assumed));
  const double p_hertz = probability_of_hertz(drops);
  ContactLaw law;
  law.tau_1_s = p_hertz * a.tau_1_s + (1.0 - p_hertz) * b.tau_1_s;
  law.sigma_s = std::sqrt(p_hertz * a.sigma_s * a.sigma_s + (1.0 - p_hertz) * b.sigma_s * b.sigma_s +
                          p_hertz * (1.0 - p_hertz) * square(a.tau_1_s - b.tau_1_s));
  law.hertz_tau_1_s = a.tau_1_s;
  law.is_significant = pooled[0].tau2_s2 > kContact.significant * pooled[0].sigma2_s2;
  return law;
}

std::optional<ContactEvidence> fit_contact(const BandLevels& levels) {
  if (levels.contact_scaling.size() < kContact.fewest_impacts || levels.f_hz.size() < kContact.fewest_bands)
    return std::nullopt;
  LevelModel model(levels);
  const std::optional<ContactFit> hertz = fit_pulse(PulseSpectrum::hertz(), kStart_s, model);
  if (!hertz) return std::nullopt;
  // the likelihoods of two pulses can be compared where the levels have the same bands, weights and variances
  model.is_fixed = true;
  const double start_s = kContact.half_sine_over_hertz * std::sqrt(std::max(hertz->tau2_s2, kMinTau_s * kMinTau_s));
  const std::optional<ContactFit> half_sine = fit_pulse(PulseSpectrum::half_sine(), start_s, model);
  if (!half_sine) return std::nullopt;
  return ContactEvidence{*hertz, *half_sine};
}

}  // namespace bouncelab::detection
