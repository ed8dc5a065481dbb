// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/contact_time.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "contact/pulse_spectrum.hpp"
#include "contact/two_way_demeaning.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kLeastImpacts = 8;
constexpr std::size_t kLeastBands = 6;
constexpr double kFirstGuess_s = 30e-6;      // steel on glass; the iteration forgets it
constexpr double kHalfSineOverHertz = 0.87;  // durations of pulses of about the same spectrum
constexpr double kShortest_s = 5e-6;         // about which the law is linear in tau^2
constexpr int kMostSteps = 25;
constexpr int kFirstRounds = 4;       // of gains and weights, which settle to a thousandth of an error
constexpr int kLaterRounds = 2;       // from those of the last step
constexpr double kLeastPulse = 0.25;  // of P, down to which a pulse is what its law says; near its first zero it is not
constexpr double kLeastTimbre = 0.03;  // spread of a level that no ball is below
constexpr double kFar = 2.5;           // standard deviations from which a level counts less

using Values = std::vector<double>;

class Fitter {
 public:
  Fitter(const BandLevels& levels, const PulseSpectrum& pulse)
      : l_(levels),
        pulse_(&pulse),
        n_(levels.contact_scaling.size()),
        m_(levels.f_hz.size()),
        level_over_pulse_(n_, m_),
        one_over_pulse_(n_, m_),
        dlogp_dtau2_(n_, m_),
        weight_(n_, m_, 1.0),
        weighed_(n_, m_),
        relative_(n_, m_),
        noise2_(n_, m_),
        gain_(n_, 1.0),
        response_(m_, 1.0),
        timbre2_(m_, 0.1),
        row_inflation_(n_, 1.0),
        is_active_(m_, false),
        active_mask_(m_, 0.0) {
    largest_scaling_ = *std::max_element(l_.contact_scaling.begin(), l_.contact_scaling.end());
    for (std::size_t k = 0; k < n_; ++k)
      gain_[k] = std::max(std::accumulate(l_.level[k].begin(), l_.level[k].end(), 0.0) / static_cast<double>(m_), 1e-9);
  }

  /// With another pulse over the same bands, once it has run.
  void change_to(const PulseSpectrum& pulse) {
    pulse_ = &pulse;
    has_run_ = true;
  }

  /// @param tau_1_s  to start from
  std::optional<ContactFit> run(double tau_1_s) {
    ContactFit fit;
    for (int step = 0; step < kMostSteps; ++step) {
      expect(tau_1_s);
      const int n_rounds = step == 0 && !has_run_ ? kFirstRounds : kLaterRounds;
      for (int round = 0; round < n_rounds; ++round) {
        adjust();
        weigh();
      }
      const auto [shift, sigma] = pooled_estimate();
      if (!std::isfinite(shift) || !std::isfinite(sigma) || !(sigma > 0.0)) return std::nullopt;
      fit = {tau_1_s * tau_1_s + shift, sigma, {}};
      const double next_s = std::sqrt(std::max(fit.tau2_s2, kShortest_s * kShortest_s));
      if (std::abs(next_s * next_s - tau_1_s * tau_1_s) < 0.02 * sigma) break;
      tau_1_s = std::clamp(next_s, 0.6 * tau_1_s, 1.7 * tau_1_s);
    }
    fit.log_likelihood = log_likelihood();
    return fit;
  }

 private:
  /// P and the change of ln P with tau_1^2, for each level; bands beyond the law's reach weigh nothing.
  void expect(double tau_1_s) {
    for (std::size_t m = 0; m < m_; ++m) {
      const double largest = l_.f_hz[m] * tau_1_s * largest_scaling_;
      if (!has_run_) is_active_[m] = pulse_->at(largest).value > kLeastPulse && largest < 1.5;
      active_mask_[m] = is_active_[m] ? 1.0 : 0.0;
    }
    for (std::size_t k = 0; k < n_; ++k) {
      for (std::size_t m = 0; m < m_; ++m) {
        const auto [value, slope] = pulse_->at(l_.f_hz[m] * l_.contact_scaling[k] * tau_1_s);
        one_over_pulse_[k][m] = value;
        dlogp_dtau2_[k][m] = slope;
      }
      compare_pulses(l_.level[k].data(), l_.f_hz.data(), 0.5 * l_.contact_scaling[k] / tau_1_s, active_mask_.data(),
                     one_over_pulse_[k], dlogp_dtau2_[k], level_over_pulse_[k], weight_[k], m_);
    }
  }

  /// @param one_over_pulse, dlogp_dtau2  hold P and its slope before
  static void compare_pulses(const double* level, const double* f_hz, double half_u_over_tau, const double* counts,
                             double* __restrict one_over_pulse, double* __restrict dlogp_dtau2,
                             double* __restrict level_over_pulse, double* __restrict weight, std::size_t n) {
    for (std::size_t m = 0; m < n; ++m) {
      const double one_over = 1.0 / (one_over_pulse[m] > 0.02 ? one_over_pulse[m] : 0.02);
      one_over_pulse[m] = one_over;
      dlogp_dtau2[m] *= half_u_over_tau * f_hz[m] * one_over;
      level_over_pulse[m] = level[m] * one_over;
      weight[m] = counts[m] * (weight[m] > 1e-12 ? weight[m] : 1e-12);
    }
  }

  /// Gains and responses that fit the levels best as they are weighed: of gains alone, sum w level / (h P) / sum w.
  void adjust() {
    for (std::size_t k = 0; k < n_; ++k) audio::multiply(weight_[k], level_over_pulse_[k], weighed_[k], m_);
    const Values of_row = sums_of_rows(weight_);
    const Values of_column = sums_of_columns(weight_);
    for (int round = 0; round < 3; ++round) {
      const Values one_over_response = inverse(response_);
      Values sums(m_, 0.0);
      for (std::size_t k = 0; k < n_; ++k) {
        gain_[k] =
            std::max(audio::dot(weighed_[k], one_over_response.data(), m_) / (of_row[k] + 1e-300), 0.1 * gain_[k]);
        audio::add_scaled(sums.data(), 1.0 / gain_[k], weighed_[k], m_);
      }
      for (std::size_t m = 0; m < m_; ++m)
        if (is_active_[m]) response_[m] = std::max(sums[m] / (of_column[m] + 1e-300), 0.1 * response_[m]);
    }
  }

  static Values inverse(Values x) {
    for (double& value : x) value = 1.0 / value;
    return x;
  }

  /// Deviations from what is expected, and the variance of the noise in them, both relative.
  void compare() {
    const Values one_over_response = inverse(response_);
    for (std::size_t k = 0; k < n_; ++k)
      compare(1.0 / gain_[k], one_over_response.data(), one_over_pulse_[k], level_over_pulse_[k], l_.noise2.data(),
              relative_[k], noise2_[k], m_);
  }

  static void compare(double one_over_gain, const double* one_over_response, const double* one_over_pulse,
                      const double* level_over_pulse, const double* noise2_of_wave, double* __restrict relative,
                      double* __restrict noise2, std::size_t n) {
    for (std::size_t m = 0; m < n; ++m) {
      const double scale = one_over_gain * one_over_response[m];
      const double unit = scale * one_over_pulse[m];
      relative[m] = scale * level_over_pulse[m] - 1.0;
      noise2[m] = noise2_of_wave[m] * unit * unit;
    }
  }

  /// Spread of timbre in each band, half its own and half the typical one: by its own alone a band in which little
  /// happened to happen would be believed too much.
  void learn_timbre() {
    Values sum(m_, 0.0), weights(m_, 1e-300);
    for (std::size_t k = 0; k < n_; ++k)
      add_excess(relative_[k], noise2_[k], timbre2_.data(), row_inflation_[k], sum.data(), weights.data(), m_);
    std::vector<double> sorted;
    for (std::size_t m = 0; m < m_; ++m) {
      sum[m] = is_active_[m] ? std::max(sum[m] / weights[m], kLeastTimbre * kLeastTimbre) : 0.0;
      if (is_active_[m]) sorted.push_back(sum[m]);
    }
    if (sorted.empty()) return;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    for (std::size_t m = 0; m < m_; ++m) timbre2_[m] = 0.5 * (sum[m] + sorted[sorted.size() / 2]);
  }

  static void add_excess(const double* relative, const double* noise2, const double* timbre2, double row_inflation,
                         double* __restrict sum, double* __restrict weights, std::size_t n) {
    for (std::size_t m = 0; m < n; ++m) {
      const double size2 = timbre2[m] + noise2[m];
      const double weight = 1.0 / (size2 * size2);
      const double largest = 2.0 * kFar * kFar * size2;
      const double square = relative[m] * relative[m] / row_inflation;
      sum[m] += ((square < largest ? square : largest) - noise2[m]) * weight;
      weights[m] += weight;
    }
  }

  /// Impacts at which something else was heard too.
  void learn_disturbances() {
    constexpr double kTypical = 1.3;  // mean of squares that noise alone hardly exceeds
    constexpr double kPrior = 4.0;    // bands that a typical impact is worth
    const double n = std::accumulate(active_mask_.begin(), active_mask_.end(), 0.0);
    Values squares(m_);
    for (std::size_t k = 0; k < n_; ++k) {
      square(relative_[k], noise2_[k], timbre2_.data(), squares.data(), m_);
      row_inflation_[k] =
          std::max(1.0, (audio::dot(squares.data(), active_mask_.data(), m_) + kPrior) / (n + kPrior) / kTypical);
    }
  }

  static void square(const double* relative, const double* noise2, const double* timbre2, double* __restrict squares,
                     std::size_t n) {
    constexpr double kLargest = 100.0;
    for (std::size_t m = 0; m < n; ++m) {
      const double square = relative[m] * relative[m] / (timbre2[m] + noise2[m]);
      squares[m] = square < kLargest ? square : kLargest;
    }
  }

  double size2(std::size_t k, std::size_t m) const { return (timbre2_[m] + noise2_[k][m]) * row_inflation_[k]; }

  void weigh() {
    compare();
    learn_timbre();
    learn_disturbances();
    for (std::size_t k = 0; k < n_; ++k)
      weigh(relative_[k], noise2_[k], timbre2_.data(), active_mask_.data(), row_inflation_[k], weight_[k], m_);
  }

  static void weigh(const double* relative, const double* noise2, const double* timbre2, const double* counts,
                    double row_inflation, double* __restrict weight, std::size_t n) {
    for (std::size_t m = 0; m < n; ++m) {
      const double size2 = (timbre2[m] + noise2[m]) * row_inflation;
      const double near = kFar * std::sqrt(size2) / (std::abs(relative[m]) + 1e-300);
      weight[m] = counts[m] * (near < 1.0 ? near : 1.0) / size2;
    }
  }

  /// Of normal levels, by band.
  std::vector<double> log_likelihood() const {
    std::vector<double> by_band;
    for (std::size_t m = 0; m < m_; ++m) {
      if (!is_active_[m]) continue;
      double sum = 0.0;
      for (std::size_t k = 0; k < n_; ++k)
        sum -= 0.5 * (std::log(size2(k, m)) + std::min(std::pow(relative_[k][m], 2) / size2(k, m), 9.0));
      by_band.push_back(sum);
    }
    return by_band;
  }

  struct PooledEstimate {
    double shift = 0.0;
    double sigma = INFINITY;
  };

  /// By how much tau_1^2 is to be raised: the mean of what the bands say, weighed by how well each knows it and by how
  /// far they disagree.
  PooledEstimate pooled_estimate() const {
    BandTable regressor = dlogp_dtau2_;
    BandTable rest = relative_;
    demean_two_way(regressor, weight_);
    demean_two_way(rest, weight_);
    std::vector<double> per_band, variance;
    for (std::size_t m = 0; m < m_; ++m) {
      double xy = 0.0, xx = 0.0;
      for (std::size_t k = 0; k < n_; ++k) {
        xy += weight_[k][m] * regressor[k][m] * rest[k][m];
        xx += weight_[k][m] * regressor[k][m] * regressor[k][m];
      }
      if (!is_active_[m] || !(xx > 0.0)) continue;
      per_band.push_back(xy / xx);
      variance.push_back(1.0 / xx);
    }
    return per_band.size() < kLeastBands ? PooledEstimate{} : pooled(per_band, variance);
  }

  /// Mean of values whose variances are known up to a factor, far-off ones counting less.
  static PooledEstimate pooled(const std::vector<double>& per_band, const std::vector<double>& variance) {
    std::vector<double> robust(per_band.size(), 1.0);
    PooledEstimate mean;
    double inflation = 1.0;
    for (int round = 0; round < 10; ++round) {
      double sum = 0.0, weights = 0.0;
      for (std::size_t m = 0; m < per_band.size(); ++m)
        sum += robust[m] / variance[m] * per_band[m], weights += robust[m] / variance[m];
      mean.shift = sum / weights;
      double chi2 = 0.0, n = 0.0;
      for (std::size_t m = 0; m < per_band.size(); ++m) {
        chi2 += robust[m] * std::pow(per_band[m] - mean.shift, 2) / variance[m];
        n += robust[m];
      }
      inflation = std::max(1.0, chi2 / std::max(n - 2.0, 1.0));  // the gains have taken up one more
      mean.sigma = std::sqrt(inflation / weights);
      for (std::size_t m = 0; m < per_band.size(); ++m)
        robust[m] =
            std::min(1.0, kFar / (std::abs(per_band[m] - mean.shift) / std::sqrt(inflation * variance[m]) + 1e-300));
    }
    return mean;
  }

  const BandLevels& l_;
  const PulseSpectrum* pulse_;
  std::size_t n_;
  std::size_t m_;
  double largest_scaling_ = 0.0;
  BandTable level_over_pulse_, one_over_pulse_, dlogp_dtau2_, weight_;
  BandTable weighed_, relative_, noise2_;
  Values gain_, response_, timbre2_, row_inflation_;
  std::vector<bool> is_active_;
  Values active_mask_;  // 1 for bands within, else 0
  bool has_run_ = false;
};

}  // namespace

std::optional<ContactEvidence> fit_contact(const BandLevels& levels) {
  if (levels.contact_scaling.size() < kLeastImpacts || levels.f_hz.size() < kLeastBands) return std::nullopt;
  Fitter fitter(levels, PulseSpectrum::hertz());
  const std::optional<ContactFit> hertz = fitter.run(kFirstGuess_s);
  if (!hertz) return std::nullopt;
  fitter.change_to(PulseSpectrum::half_sine());
  const std::optional<ContactFit> half_sine =
      fitter.run(kHalfSineOverHertz * std::sqrt(std::max(hertz->tau2_s2, kShortest_s * kShortest_s)));
  if (!half_sine) return std::nullopt;
  return ContactEvidence{*hertz, *half_sine};
}

}  // namespace bouncelab::detection
