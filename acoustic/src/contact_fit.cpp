// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_law.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "pulse_spectrum.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kLeastImpacts = 8;
constexpr std::size_t kLeastBands = 6;
constexpr double kFirstGuess_s = 30e-6;      // steel on glass; the iteration forgets it
constexpr double kHalfSineOverHertz = 0.87;  // durations of pulses of about the same spectrum
constexpr double kShortest_s = 5e-6;         // about which the law is linear in tau^2
constexpr int kMostSteps = 25;
constexpr double kLeastPulse = 0.25;  // of P, down to which a pulse is what its law says; near its first zero it is not
constexpr double kLeastTimbre = 0.03;  // spread of a level that no ball is below
constexpr double kFar = 2.5;           // standard deviations from which a level counts less

using Table = std::vector<std::vector<double>>;  // by impact and band

Table table(std::size_t n_impacts, std::size_t n_bands, double value) {
  return Table(n_impacts, std::vector<double>(n_bands, value));
}

/// Takes off weighted means of rows and columns until none is left.
void sweep(Table& x, const Table& weight) {
  constexpr int kSweeps = 12;
  const std::size_t n_bands = x.front().size();
  for (int round = 0; round < kSweeps; ++round) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      double sum = 0.0, weights = 1e-300;
      for (std::size_t m = 0; m < n_bands; ++m) sum += weight[k][m] * x[k][m], weights += weight[k][m];
      for (double& value : x[k]) value -= sum / weights;
    }
    for (std::size_t m = 0; m < n_bands; ++m) {
      double sum = 0.0, weights = 1e-300;
      for (std::size_t k = 0; k < x.size(); ++k) sum += weight[k][m] * x[k][m], weights += weight[k][m];
      for (auto& row : x) row[m] -= sum / weights;
    }
  }
}

class Fitter {
 public:
  /// @param first  tau_1 to start from
  Fitter(const BandLevels& levels, const PulseSpectrum& pulse, double first_s, std::vector<bool> within)
      : l_(levels),
        pulse_(pulse),
        n_(levels.u.size()),
        m_(levels.f_hz.size()),
        gain_(n_, 1.0),
        response_(m_, 1.0),
        timbre2_(m_, 0.1),
        disturbed_(n_, 1.0),
        first_s_(first_s),
        within_(std::move(within)),
        is_given_(!within_.empty()) {
    slowest_u_ = *std::max_element(l_.u.begin(), l_.u.end());
    for (std::size_t k = 0; k < n_; ++k)
      gain_[k] = std::max(std::accumulate(l_.level[k].begin(), l_.level[k].end(), 0.0) / static_cast<double>(m_), 1e-9);
  }

  const std::vector<bool>& within() const { return within_; }

  std::optional<ContactFit> run() {
    ContactFit fit;
    double tau_1_s = first_s_;
    for (int step = 0; step < kMostSteps; ++step) {
      expect(tau_1_s);
      for (int round = 0; round < 4; ++round) {
        adjust();
        weigh();
      }
      const auto [shift, sigma] = opinion();
      if (!std::isfinite(shift) || !std::isfinite(sigma) || !(sigma > 0.0)) return std::nullopt;
      fit = {tau_1_s * tau_1_s + shift, sigma, log_likelihood()};
      const double next_s = std::sqrt(std::max(fit.tau2_s2, kShortest_s * kShortest_s));
      if (std::abs(next_s * next_s - tau_1_s * tau_1_s) < 0.02 * sigma) break;
      tau_1_s = std::clamp(next_s, 0.6 * tau_1_s, 1.7 * tau_1_s);
    }
    return fit;
  }

 private:
  /// P and the change of ln P with tau_1^2, for each level; bands beyond the law's reach weigh nothing.
  void expect(double tau_1_s) {
    pulse_value_ = table(n_, m_, 0.0);
    duller_ = pulse_value_;
    within_.resize(m_);
    std::vector<float> value(2), slope(2);
    for (std::size_t m = 0; m < m_; ++m) {
      pulse_.tabulate(l_.f_hz[m] * tau_1_s * slowest_u_, value, slope);
      if (!is_given_) within_[m] = value[1] > kLeastPulse && l_.f_hz[m] * tau_1_s * slowest_u_ < 1.5;
      for (std::size_t k = 0; k < n_; ++k) {
        const double x = l_.f_hz[m] * l_.u[k];
        pulse_.tabulate(x * tau_1_s, value, slope);
        pulse_value_[k][m] = std::max(static_cast<double>(value[1]), 0.02);
        duller_[k][m] = 0.5 * x / tau_1_s * static_cast<double>(slope[1]) / pulse_value_[k][m];
      }
    }
    if (weight_.empty()) weight_ = table(n_, m_, 1.0);
    for (std::size_t m = 0; m < m_; ++m)
      for (auto& row : weight_) row[m] = within_[m] ? std::max(row[m], 1e-12) : 0.0;
  }

  double expected(std::size_t k, std::size_t m) const { return gain_[k] * response_[m] * pulse_value_[k][m]; }

  /// Gains and responses that fit the levels best as they are weighed.
  void adjust() {
    for (int round = 0; round < 3; ++round) {
      for (std::size_t k = 0; k < n_; ++k) {
        double xy = 0.0, xx = 1e-300;
        for (std::size_t m = 0; m < m_; ++m) add(k, m, expected(k, m) / gain_[k], xy, xx);
        gain_[k] = std::max(xy / xx, 0.1 * gain_[k]);
      }
      for (std::size_t m = 0; m < m_; ++m) {
        if (!within_[m]) continue;
        double xy = 0.0, xx = 1e-300;
        for (std::size_t k = 0; k < n_; ++k) add(k, m, expected(k, m) / response_[m], xy, xx);
        response_[m] = std::max(xy / xx, 0.1 * response_[m]);
      }
    }
  }

  void add(std::size_t k, std::size_t m, double per_unit, double& xy, double& xx) const {
    const double e = expected(k, m);
    const double w = weight_[k][m] / (e * e);
    xy += w * l_.level[k][m] * per_unit;
    xx += w * per_unit * per_unit;
  }

  double relative(std::size_t k, std::size_t m) const { return l_.level[k][m] / expected(k, m) - 1.0; }
  double noise2(std::size_t k, std::size_t m) const { return l_.noise2[m] / std::pow(expected(k, m), 2); }

  /// Spread of timbre in each band, half its own and half the typical one: by its own alone a band in which little
  /// happened to happen would be believed too much.
  void learn_timbre() {
    std::vector<double> own(m_, 0.0);
    std::vector<double> sorted;
    for (std::size_t m = 0; m < m_; ++m) {
      if (!within_[m]) continue;
      double sum = 0.0, weights = 1e-300;
      for (std::size_t k = 0; k < n_; ++k) {
        const double noise = noise2(k, m);
        const double size2 = timbre2_[m] + noise;
        const double excess = std::min(std::pow(relative(k, m), 2) / disturbed_[k], 2.0 * kFar * kFar * size2) - noise;
        sum += excess / (size2 * size2);
        weights += 1.0 / (size2 * size2);
      }
      own[m] = std::max(sum / weights, kLeastTimbre * kLeastTimbre);
      sorted.push_back(own[m]);
    }
    if (sorted.empty()) return;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    for (std::size_t m = 0; m < m_; ++m) timbre2_[m] = 0.5 * (own[m] + sorted[sorted.size() / 2]);
  }

  /// Impacts at which something else was heard too.
  void learn_disturbances() {
    constexpr double kTypical = 1.3;  // mean of squares that noise alone hardly exceeds
    constexpr double kPrior = 4.0;    // bands that a typical impact is worth
    for (std::size_t k = 0; k < n_; ++k) {
      double sum = 0.0, n = 0.0;
      for (std::size_t m = 0; m < m_; ++m) {
        if (!within_[m]) continue;
        sum += std::min(std::pow(relative(k, m), 2) / (timbre2_[m] + noise2(k, m)), 100.0);
        n += 1.0;
      }
      disturbed_[k] = std::max(1.0, (sum + kPrior) / (n + kPrior) / kTypical);
    }
  }

  double size2(std::size_t k, std::size_t m) const { return (timbre2_[m] + noise2(k, m)) * disturbed_[k]; }

  void weigh() {
    learn_timbre();
    learn_disturbances();
    for (std::size_t m = 0; m < m_; ++m)
      for (std::size_t k = 0; k < n_ && within_[m]; ++k) {
        const double far = std::abs(relative(k, m)) / std::sqrt(size2(k, m));
        weight_[k][m] = std::min(1.0, kFar / (far + 1e-300)) / size2(k, m);
      }
  }

  /// Of normal levels, by band.
  std::vector<double> log_likelihood() const {
    std::vector<double> by_band;
    for (std::size_t m = 0; m < m_; ++m) {
      if (!within_[m]) continue;
      double sum = 0.0;
      for (std::size_t k = 0; k < n_; ++k)
        sum -= 0.5 * (std::log(size2(k, m)) + std::min(std::pow(relative(k, m), 2) / size2(k, m), 9.0));
      by_band.push_back(sum);
    }
    return by_band;
  }

  struct Opinion {
    double shift = 0.0;
    double sigma = INFINITY;
  };

  /// By how much tau_1^2 is to be raised: the mean of what the bands say, weighed by how well each knows it and by how
  /// far they disagree.
  Opinion opinion() const {
    Table regressor = duller_;
    Table rest = table(n_, m_, 0.0);
    for (std::size_t k = 0; k < n_; ++k)
      for (std::size_t m = 0; m < m_; ++m) rest[k][m] = relative(k, m);
    sweep(regressor, weight_);
    sweep(rest, weight_);
    std::vector<double> says, variance;
    for (std::size_t m = 0; m < m_; ++m) {
      double xy = 0.0, xx = 0.0;
      for (std::size_t k = 0; k < n_; ++k) {
        xy += weight_[k][m] * regressor[k][m] * rest[k][m];
        xx += weight_[k][m] * regressor[k][m] * regressor[k][m];
      }
      if (!within_[m] || !(xx > 0.0)) continue;
      says.push_back(xy / xx);
      variance.push_back(1.0 / xx);
    }
    return says.size() < kLeastBands ? Opinion{} : pooled(says, variance);
  }

  /// Mean of values whose variances are known up to a factor, far-off ones counting less.
  static Opinion pooled(const std::vector<double>& says, const std::vector<double>& variance) {
    std::vector<double> robust(says.size(), 1.0);
    Opinion mean;
    double inflation = 1.0;
    for (int round = 0; round < 10; ++round) {
      double sum = 0.0, weights = 0.0;
      for (std::size_t m = 0; m < says.size(); ++m)
        sum += robust[m] / variance[m] * says[m], weights += robust[m] / variance[m];
      mean.shift = sum / weights;
      double chi2 = 0.0, n = 0.0;
      for (std::size_t m = 0; m < says.size(); ++m) {
        chi2 += robust[m] * std::pow(says[m] - mean.shift, 2) / variance[m];
        n += robust[m];
      }
      inflation = std::max(1.0, chi2 / std::max(n - 2.0, 1.0));  // the gains have taken up one more
      mean.sigma = std::sqrt(inflation / weights);
      for (std::size_t m = 0; m < says.size(); ++m)
        robust[m] =
            std::min(1.0, kFar / (std::abs(says[m] - mean.shift) / std::sqrt(inflation * variance[m]) + 1e-300));
    }
    return mean;
  }

  const BandLevels& l_;
  const PulseSpectrum& pulse_;
  std::size_t n_;
  std::size_t m_;
  double slowest_u_ = 0.0;
  std::vector<double> gain_, response_, timbre2_, disturbed_;
  double first_s_;
  std::vector<bool> within_;
  bool is_given_;
  Table pulse_value_, duller_, weight_;
};

}  // namespace

std::optional<ContactEvidence> fit_contact(const BandLevels& levels) {
  if (levels.u.size() < kLeastImpacts || levels.f_hz.size() < kLeastBands) return std::nullopt;
  Fitter with_hertz(levels, PulseSpectrum::hertz(), kFirstGuess_s, {});
  const std::optional<ContactFit> hertz = with_hertz.run();
  if (!hertz) return std::nullopt;
  const double first_s = kHalfSineOverHertz * std::sqrt(std::max(hertz->tau2_s2, kShortest_s * kShortest_s));
  const std::optional<ContactFit> half_sine =
      Fitter(levels, PulseSpectrum::half_sine(), first_s, with_hertz.within()).run();
  if (!half_sine) return std::nullopt;
  return ContactEvidence{*hertz, *half_sine};
}

}  // namespace bouncelab
