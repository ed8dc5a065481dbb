// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "pulse_spectrum.hpp"
#include "vector_clones.hpp"

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

/// Values by impact and band.
class Table {
 public:
  Table() = default;
  Table(std::size_t n_impacts, std::size_t n_bands, double value = 0.0)
      : n_bands_(n_bands), values_(n_impacts * n_bands, value) {}
  bool empty() const { return values_.empty(); }
  std::size_t n_impacts() const { return values_.size() / n_bands_; }
  std::size_t n_bands() const { return n_bands_; }
  double* operator[](std::size_t k) { return values_.data() + k * n_bands_; }
  const double* operator[](std::size_t k) const { return values_.data() + k * n_bands_; }

 private:
  std::size_t n_bands_ = 1;
  std::vector<double> values_;
};

using Values = std::vector<double>;

BOUNCELAB_VECTOR_CLONES double dot(const double* a, const double* b, std::size_t n) {
  constexpr std::size_t kLanes = 8;
  std::array<double, kLanes> sums{};
  std::size_t m = 0;
  for (; m + kLanes <= n; m += kLanes)
    for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += a[m + lane] * b[m + lane];
  for (; m < n; ++m) sums[0] += a[m] * b[m];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

BOUNCELAB_VECTOR_CLONES void add_scaled(double* __restrict to, double factor, const double* x, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) to[m] += factor * x[m];
}

Values sums_of_rows(const Table& x) {
  const Values ones(x.n_bands(), 1.0);
  Values sums(x.n_impacts());
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = dot(x[k], ones.data(), x.n_bands());
  return sums;
}

Values sums_of_columns(const Table& x) {
  Values sums(x.n_bands(), 0.0);
  for (std::size_t k = 0; k < x.n_impacts(); ++k) add_scaled(sums.data(), 1.0, x[k], x.n_bands());
  return sums;
}

/// One round of taking off weighted means of rows, then of columns.
/// @param per_row, per_column  1 / sum of the weights
/// @return sum of squares of the means of columns
BOUNCELAB_VECTOR_CLONES double sweep_once(double* __restrict x, const double* __restrict weight, const double* per_row,
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

/// Takes off weighted means of rows and columns until none is left.
void sweep(Table& x, const Table& weight) {
  constexpr int kSweeps = 12;
  constexpr double kLeft = 1e-20;  // of the squares that the first sweep finds
  Values per_row = sums_of_rows(weight);
  Values per_column = sums_of_columns(weight);
  for (double& sum : per_row) sum = 1.0 / (sum + 1e-300);
  for (double& sum : per_column) sum = 1.0 / (sum + 1e-300);
  Values means(x.n_bands());
  double first = 0.0;
  for (int round = 0; round < kSweeps; ++round) {
    const double squares =
        sweep_once(x[0], weight[0], per_row.data(), per_column.data(), means.data(), x.n_impacts(), x.n_bands());
    if (round == 0) first = squares;
    if (squares <= kLeft * first) break;
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
        level_over_pulse_(n_, m_),
        one_over_pulse_(n_, m_),
        duller_(n_, m_),
        weight_(n_, m_, 1.0),
        weighed_(n_, m_),
        relative_(n_, m_),
        noise2_(n_, m_),
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
    within_.resize(m_);
    counts_.assign(m_, 0.0);
    for (std::size_t m = 0; m < m_; ++m) {
      const double largest = l_.f_hz[m] * tau_1_s * slowest_u_;
      if (!is_given_) within_[m] = pulse_.at(largest).value > kLeastPulse && largest < 1.5;
      counts_[m] = within_[m] ? 1.0 : 0.0;
      for (std::size_t k = 0; k < n_; ++k) {
        const double x = l_.f_hz[m] * l_.u[k];
        const auto [value, slope] = pulse_.at(x * tau_1_s);
        one_over_pulse_[k][m] = 1.0 / std::max(value, 0.02);
        level_over_pulse_[k][m] = l_.level[k][m] * one_over_pulse_[k][m];
        duller_[k][m] = 0.5 * x / tau_1_s * slope * one_over_pulse_[k][m];
        weight_[k][m] = within_[m] ? std::max(weight_[k][m], 1e-12) : 0.0;
      }
    }
  }

  /// Gains and responses that fit the levels best as they are weighed: of gains alone, sum w level / (h P) / sum w.
  void adjust() {
    for (std::size_t k = 0; k < n_; ++k)
      for (std::size_t m = 0; m < m_; ++m) weighed_[k][m] = weight_[k][m] * level_over_pulse_[k][m];
    const Values of_row = sums_of_rows(weight_);
    const Values of_column = sums_of_columns(weight_);
    for (int round = 0; round < 3; ++round) {
      const Values one_over_response = inverse(response_);
      Values sums(m_, 0.0);
      for (std::size_t k = 0; k < n_; ++k) {
        gain_[k] = std::max(dot(weighed_[k], one_over_response.data(), m_) / (of_row[k] + 1e-300), 0.1 * gain_[k]);
        add_scaled(sums.data(), 1.0 / gain_[k], weighed_[k], m_);
      }
      for (std::size_t m = 0; m < m_; ++m)
        if (within_[m]) response_[m] = std::max(sums[m] / (of_column[m] + 1e-300), 0.1 * response_[m]);
    }
  }

  static Values inverse(Values x) {
    for (double& value : x) value = 1.0 / value;
    return x;
  }

  /// Deviations from what is expected, and the variance of the noise in them, both relative.
  void compare() {
    const Values one_over_response = inverse(response_);
    for (std::size_t k = 0; k < n_; ++k) {
      const double one_over_gain = 1.0 / gain_[k];
      for (std::size_t m = 0; m < m_; ++m) {
        const double scale = one_over_gain * one_over_response[m];
        const double unit = scale * one_over_pulse_[k][m];
        relative_[k][m] = scale * level_over_pulse_[k][m] - 1.0;
        noise2_[k][m] = l_.noise2[m] * unit * unit;
      }
    }
  }

  /// Spread of timbre in each band, half its own and half the typical one: by its own alone a band in which little
  /// happened to happen would be believed too much.
  void learn_timbre() {
    Values sum(m_, 0.0), weights(m_, 1e-300);
    for (std::size_t k = 0; k < n_; ++k)
      add_excess(relative_[k], noise2_[k], timbre2_.data(), disturbed_[k], sum.data(), weights.data(), m_);
    std::vector<double> sorted;
    for (std::size_t m = 0; m < m_; ++m) {
      sum[m] = within_[m] ? std::max(sum[m] / weights[m], kLeastTimbre * kLeastTimbre) : 0.0;
      if (within_[m]) sorted.push_back(sum[m]);
    }
    if (sorted.empty()) return;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    for (std::size_t m = 0; m < m_; ++m) timbre2_[m] = 0.5 * (sum[m] + sorted[sorted.size() / 2]);
  }

  BOUNCELAB_VECTOR_CLONES static void add_excess(const double* relative, const double* noise2, const double* timbre2,
                                                 double disturbed, double* __restrict sum, double* __restrict weights,
                                                 std::size_t n) {
    for (std::size_t m = 0; m < n; ++m) {
      const double size2 = timbre2[m] + noise2[m];
      const double weight = 1.0 / (size2 * size2);
      const double largest = 2.0 * kFar * kFar * size2;
      const double square = relative[m] * relative[m] / disturbed;
      sum[m] += ((square < largest ? square : largest) - noise2[m]) * weight;
      weights[m] += weight;
    }
  }

  /// Impacts at which something else was heard too.
  void learn_disturbances() {
    constexpr double kTypical = 1.3;  // mean of squares that noise alone hardly exceeds
    constexpr double kPrior = 4.0;    // bands that a typical impact is worth
    const double n = std::accumulate(counts_.begin(), counts_.end(), 0.0);
    Values squares(m_);
    for (std::size_t k = 0; k < n_; ++k) {
      square(relative_[k], noise2_[k], timbre2_.data(), squares.data(), m_);
      disturbed_[k] = std::max(1.0, (dot(squares.data(), counts_.data(), m_) + kPrior) / (n + kPrior) / kTypical);
    }
  }

  BOUNCELAB_VECTOR_CLONES static void square(const double* relative, const double* noise2, const double* timbre2,
                                             double* __restrict squares, std::size_t n) {
    constexpr double kLargest = 100.0;
    for (std::size_t m = 0; m < n; ++m) {
      const double square = relative[m] * relative[m] / (timbre2[m] + noise2[m]);
      squares[m] = square < kLargest ? square : kLargest;
    }
  }

  double size2(std::size_t k, std::size_t m) const { return (timbre2_[m] + noise2_[k][m]) * disturbed_[k]; }

  void weigh() {
    compare();
    learn_timbre();
    learn_disturbances();
    for (std::size_t k = 0; k < n_; ++k)
      weigh(relative_[k], noise2_[k], timbre2_.data(), counts_.data(), disturbed_[k], weight_[k], m_);
  }

  BOUNCELAB_VECTOR_CLONES static void weigh(const double* relative, const double* noise2, const double* timbre2,
                                            const double* counts, double disturbed, double* __restrict weight,
                                            std::size_t n) {
    for (std::size_t m = 0; m < n; ++m) {
      const double size2 = (timbre2[m] + noise2[m]) * disturbed;
      const double near = kFar * std::sqrt(size2) / (std::abs(relative[m]) + 1e-300);
      weight[m] = counts[m] * (near < 1.0 ? near : 1.0) / size2;
    }
  }

  /// Of normal levels, by band.
  std::vector<double> log_likelihood() const {
    std::vector<double> by_band;
    for (std::size_t m = 0; m < m_; ++m) {
      if (!within_[m]) continue;
      double sum = 0.0;
      for (std::size_t k = 0; k < n_; ++k)
        sum -= 0.5 * (std::log(size2(k, m)) + std::min(std::pow(relative_[k][m], 2) / size2(k, m), 9.0));
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
    Table rest = relative_;
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
  Table level_over_pulse_, one_over_pulse_, duller_, weight_;
  Table weighed_, relative_, noise2_;
  Values gain_, response_, timbre2_, disturbed_;
  double first_s_;
  std::vector<bool> within_;
  bool is_given_;
  Values counts_;  // 1 for bands within, else 0
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
