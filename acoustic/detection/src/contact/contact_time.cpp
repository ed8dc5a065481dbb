// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/contact_time.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include <Eigen/Core>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::detection {
namespace {

/// At most kContact.most_impacts, evenly over the list, without the slowest.
std::vector<TimedImpact> thin_out(std::vector<TimedImpact> impacts) {
  double fastest_mps = 0.0;
  for (const TimedImpact& impact : impacts) fastest_mps = std::max(fastest_mps, impact.v_mps);
  std::erase_if(impacts, [&](const TimedImpact& impact) {
    return impact.v_mps < kContact.least_speed * fastest_mps || !(impact.fit.amplitude > 0.0);
  });
  if (impacts.size() <= kContact.most_impacts) return impacts;
  std::vector<TimedImpact> chosen;
  for (std::size_t k = 0; k < kContact.most_impacts; ++k)
    chosen.push_back(impacts[k * impacts.size() / kContact.most_impacts]);
  return chosen;
}

struct Band {
  std::size_t from = 0;
  std::size_t to = 0;      // bins from ... to - 1
  double energy = 0.0;     // of the template
  double noise = 0.0;      // variance in each real and imaginary part
  double own_noise = 0.0;  // part of the level of a training impact of amplitude 1 that is its own noise
};

double noise_at(const Subbands& subbands, std::size_t bin) {
  std::size_t subband = 0;
  while (subband + 1 < subbands.n() && subbands.edge[subband + 1] <= bin) ++subband;
  return subbands.noise[subband];
}

std::vector<Band> choose_bands(const ImpactTemplate& learned) {
  const std::size_t n_bins = learned.filter.spectrum().size() - 1;
  const std::size_t width = std::max(kContact.fewest_bins, n_bins / kContact.most_bands);
  std::vector<Band> all;
  for (std::size_t b = 1; b + width <= n_bins; b += width) {
    Band band{b, b + width, learned.filter.energy(b, b + width) + 1e-30, noise_at(learned.subbands, b + width / 2),
              0.0};
    band.own_noise = 2.0 * band.noise * static_cast<double>(width) / (learned.training_weight * band.energy);
    all.push_back(band);
  }
  std::vector<Band> bands;
  for (std::size_t m = 0; m < all.size(); ++m) {
    std::vector<double> around;
    for (std::size_t c = m > kContact.neighbours ? m - kContact.neighbours : 0;
         c < std::min(m + kContact.neighbours + 1, all.size()); ++c)
      around.push_back(all[c].energy);
    const std::size_t lower_middle = (around.size() - 1) / 2;
    if (all[m].energy >= order_statistic(std::move(around), lower_middle) &&
        kContact.least_template_snr * all[m].own_noise <= 1.0)
      bands.push_back(all[m]);
  }
  return bands;
}

double centre_bin(const MatchedFilter& filter, const Band& band) {
  double moment = 0.0;
  for (std::size_t k = band.from; k < band.to; ++k) moment += static_cast<double>(k) * filter.energy(k, k + 1);
  return moment / band.energy;
}

}  // namespace

BandLevels measure_levels(WhiteSound& white, const ImpactTemplate& learned, const std::vector<TimedImpact>& impacts) {
  BandLevels levels;
  const double rate_hz = white.source().rate_hz;
  const std::size_t n_window = learned.filter.n_window();
  const std::vector<Band> bands = choose_bands(learned);
  for (const Band& band : bands) {
    levels.f_hz.push_back(rate_hz / static_cast<double>(n_window) * centre_bin(learned.filter, band));
    levels.noise2.push_back(band.noise / band.energy);
  }
  const audio::RealFft fourier(n_window);
  std::vector<float> window(learned.n_template);
  for (const TimedImpact& impact : thin_out(impacts)) {
    const double position = impact.fit.t_s * rate_hz - learned.contact_index;
    const auto first = static_cast<std::int64_t>(std::floor(position));
    white.read(learned.whitener, first, window);  // zeros follow
    const audio::Spectrum in_phase =
        audio::phase_shifted(audio::product_conj(learned.filter.spectrum(), fourier.forward(window)),
                             learned.filter.omega() * (position - static_cast<double>(first)));
    const bool is_training = std::any_of(learned.training_t_s.begin(), learned.training_t_s.end(), [&](double t_s) {
      return std::abs(t_s - impact.fit.t_s) < kContact.same_impact_s;
    });
    std::vector<double> row;
    for (const Band& band : bands) {
      const double sum = std::accumulate(in_phase.re.begin() + static_cast<std::ptrdiff_t>(band.from),
                                         in_phase.re.begin() + static_cast<std::ptrdiff_t>(band.to), 0.0);
      row.push_back(sum / band.energy - (is_training ? impact.fit.amplitude * band.own_noise : 0.0));
    }
    levels.contact_scaling.push_back(pow(impact.v_mps, -0.2));
    levels.level.push_back(std::move(row));
  }
  return levels;
}

namespace {

constexpr double kLargestArgument = 4.0;  // of the spectrum
constexpr double kPerUnit = 512.0;

/// Of Hertz's pulse, with its slope, in steps of 1 / kPerUnit.
std::vector<PulseSpectrum> tabulated_pulse() {
  // the trapezoidal rule over theta, s = (1 - cos theta)/2, where force ds/dtheta is smooth and periodic; the pulse is
  // symmetric about the middle
  constexpr int kAll = 48;
  constexpr int kNodes = kAll / 2;
  std::vector<double> middle_out(kNodes), weight(kNodes);
  double total = 0.0;
  for (int q = 0; q < kNodes; ++q) {
    const double theta = kPi * (q + 0.5) / kAll;
    middle_out[q] = -0.5 * cos(theta);
    weight[q] = sin(theta) * hertz_force(0.5 + middle_out[q]);
    total += weight[q];
  }
  // each node's phasor advances by its own angle from x to x: 2048 roundings
  std::vector<double> slope_weight(kNodes), c(kNodes, 1.0), s(kNodes, 0.0), turn_c(kNodes), turn_s(kNodes);
  for (int q = 0; q < kNodes; ++q) {
    const double phase = 2.0 * kPi * middle_out[q];
    weight[q] /= total;
    slope_weight[q] = -weight[q] * phase;
    turn_c[q] = cos(phase / kPerUnit);
    turn_s[q] = sin(phase / kPerUnit);
  }
  std::vector<PulseSpectrum> table;
  for (int k = 0; k <= static_cast<int>(kLargestArgument * kPerUnit); ++k) {
    PulseSpectrum& at = table.emplace_back();
    for (int q = 0; q < kNodes; ++q) {
      at.value += weight[q] * c[q];
      at.slope += slope_weight[q] * s[q];
    }
    for (int q = 0; q < kNodes; ++q) {
      const double next_c = c[q] * turn_c[q] - s[q] * turn_s[q];
      s[q] = c[q] * turn_s[q] + s[q] * turn_c[q];
      c[q] = next_c;
    }
  }
  return table;
}

}  // namespace

PulseSpectrum pulse_spectrum(double x) {
  static const std::vector<PulseSpectrum> table = tabulated_pulse();
  const double place = x * kPerUnit;
  const auto index = static_cast<std::size_t>(place);
  if (index + 1 >= table.size()) return {};
  const double part = place - static_cast<double>(index);
  const PulseSpectrum &a = table[index], &b = table[index + 1];
  return {a.value + part * (b.value - a.value), a.slope + part * (b.slope - a.slope)};
}

namespace {

/// Weighted mean over drops.
ContactFit pool(const std::vector<ContactFit>& drops) {
  ContactFit pooled;
  double weights = 0.0;
  for (const ContactFit& fit : drops) {
    const double weight = 1.0 / (fit.sigma2_s2 * fit.sigma2_s2);
    weights += weight;
    pooled.tau2_s2 += weight * fit.tau2_s2;
  }
  pooled.tau2_s2 /= weights;
  double chi2 = 0.0;
  for (const ContactFit& fit : drops) chi2 += square((fit.tau2_s2 - pooled.tau2_s2) / fit.sigma2_s2);
  const double scatter = drops.size() > 1 ? std::max(1.0, chi2 / static_cast<double>(drops.size() - 1)) : 1.0;
  pooled.sigma2_s2 = std::sqrt(scatter / weights);
  return pooled;
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

/// Values by band (row) and impact (column).
using BandTable = Eigen::ArrayXXd;
using Values = Eigen::ArrayXd;

/// Sum of products, in the same order on all processors.
template <class A, class B>
double dot(const A& a, const B& b) {
  return audio::dot(a.data(), b.data(), static_cast<std::size_t>(a.size()));
}

/// Sum over the bands, of each impact.
Values sums_over_bands(const BandTable& x) {
  const Values ones = Values::Ones(x.rows());
  Values sums(x.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k) sums[k] = dot(x.col(k), ones);
  return sums;
}

Values sums_over_impacts(const BandTable& x) {
  Values sums = Values::Zero(x.rows());
  for (Eigen::Index k = 0; k < x.cols(); ++k) sums += x.col(k);
  return sums;
}

/// Weighted two-way demeaning: subtracts weighted means of impacts and of bands in turns, until those of the bands have
/// fallen to 1e-4 of the first, at most twelve times. What is left is orthogonal to the effects of both (the within
/// transformation of a two-way fixed-effects regression).
/// @param weight  of the size of x, not negative
void demean_two_way(BandTable& x, const BandTable& weight) {
  constexpr int kMaxRounds = 12;
  constexpr double kConverged = 1e-8;  // of the sum of squares of the first round
  const Values per_impact = 1.0 / (sums_over_bands(weight) + 1e-300);
  const Values per_band = 1.0 / (sums_over_impacts(weight) + 1e-300);
  double first = 0.0;
  for (int round = 0; round < kMaxRounds; ++round) {
    Values means = Values::Zero(x.rows());
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      x.col(k) -= per_impact[k] * dot(weight.col(k), x.col(k));
      means += weight.col(k) * x.col(k);
    }
    means *= per_band;
    x.colwise() -= means;
    const double squares = dot(means, means);
    if (round == 0) first = squares;
    if (squares <= kConverged * first) break;
  }
}

/// Model of the levels of a drop's impacts k in bands m,
///
///   level_km = c_k h_m P(f_m tau_1 u_k) (1 + scatter_m) + noise_m,   u_k = v_k^(-1/5)
///
/// with an amplitude c_k for each impact and a response h_m for each band; and the weight of each level in its fit.
struct LevelModel {
  explicit LevelModel(const BandLevels& of)
      : levels(of),
        n_bands(static_cast<Eigen::Index>(of.f_hz.size())),
        n_impacts(static_cast<Eigen::Index>(of.contact_scaling.size())) {
    for (Eigen::Index k = 0; k < n_impacts; ++k) {
      const std::vector<double>& row = of.level[static_cast<std::size_t>(k)];
      amplitude[k] = std::max(std::accumulate(row.begin(), row.end(), 0.0) / static_cast<double>(n_bands), 1e-9);
    }
  }
  /// Expected square of a relative residual, by band.
  Values variance(Eigen::Index k) const { return (scatter2 + relative_noise2.col(k)) * row_inflation[k]; }

  const BandLevels& levels;
  Eigen::Index n_bands, n_impacts;
  BandTable level_over_pulse{n_bands, n_impacts};          // level / P
  BandTable one_over_pulse{n_bands, n_impacts};            // 1 / P, at most 50
  BandTable dlogp_dtau2{n_bands, n_impacts};               // d ln P / d tau_1^2
  BandTable weight = BandTable::Ones(n_bands, n_impacts);  // of each level
  BandTable residual{n_bands, n_impacts};                  // relative: level / (c h P) - 1
  BandTable relative_noise2{n_bands, n_impacts};           // variance of the noise in it
  Values amplitude = Values::Ones(n_impacts);              // c_k
  Values response = Values::Ones(n_bands);                 // h_m
  Values scatter2 = Values::Constant(n_bands, 0.1);        // variance of the levels' scatter, by band
  Values row_inflation =
      Values::Ones(n_impacts);  // factor >= 1 on the variance of impacts at which there was another sound too
  Values active =
      Values::Zero(n_bands);  // 1 in bands in which P is large enough for the model of the pulse to hold, else 0
};

/// Sets P and its derivative at a contact time, and the active bands.
void set_pulse(double tau_1_s, LevelModel& model) {
  const BandLevels& l = model.levels;
  const double largest_scaling = *std::max_element(l.contact_scaling.begin(), l.contact_scaling.end());
  for (std::size_t m = 0; m < l.f_hz.size(); ++m) {
    const double largest = l.f_hz[m] * tau_1_s * largest_scaling;
    const bool holds = pulse_spectrum(largest).value > kContact.least_pulse && largest < kContact.most_argument;
    model.active[static_cast<Eigen::Index>(m)] = holds ? 1.0 : 0.0;
  }
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    const double u = l.contact_scaling[static_cast<std::size_t>(k)];
    const double half_u_over_tau = 0.5 * u / tau_1_s;
    for (Eigen::Index m = 0; m < model.n_bands; ++m) {
      const double f_hz = l.f_hz[static_cast<std::size_t>(m)];
      const auto [value, slope] = pulse_spectrum(f_hz * u * tau_1_s);
      const double one_over = 1.0 / std::max(value, 0.02);
      model.one_over_pulse(m, k) = one_over;
      model.dlogp_dtau2(m, k) = slope * (half_u_over_tau * f_hz * one_over);
      model.level_over_pulse(m, k) = l.level[static_cast<std::size_t>(k)][static_cast<std::size_t>(m)] * one_over;
    }
    model.weight.col(k) = model.active * model.weight.col(k).max(1e-12);
  }
}

/// Amplitudes and responses that fit the levels best with the present weights: alternately sum w level / (h P) / sum w
/// over bands and sum w level / (c P) / sum w over impacts.
void fit_amplitudes(LevelModel& model) {
  const BandTable weighted = model.weight * model.level_over_pulse;
  const Values weight_of_impact = sums_over_bands(model.weight) + 1e-300;
  const Values weight_of_band = sums_over_impacts(model.weight) + 1e-300;
  for (int round = 0; round < 3; ++round) {
    const Values one_over_response = 1.0 / model.response;
    Values sums = Values::Zero(model.n_bands);
    for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
      double& c = model.amplitude[k];
      c = std::max(dot(weighted.col(k), one_over_response) / weight_of_impact[k], 0.1 * c);
      sums += 1.0 / c * weighted.col(k);
    }
    const Values response = (sums / weight_of_band).max(0.1 * model.response);
    model.response = (model.active > 0.0).select(response, model.response);
  }
}

void set_residuals(LevelModel& model) {
  const Values one_over_response = 1.0 / model.response;
  const auto noise2 = Eigen::Map<const Values>(model.levels.noise2.data(), model.n_bands);
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    const Values scale = 1.0 / model.amplitude[k] * one_over_response;
    const Values unit = scale * model.one_over_pulse.col(k);
    model.residual.col(k) = scale * model.level_over_pulse.col(k) - 1.0;
    model.relative_noise2.col(k) = noise2 * unit * unit;
  }
}

/// Scatter of each band, half its own and half the median one: the own estimate of a band that happened to scatter
/// little would give it too much weight. By what the squares of the residuals have beyond the noise, weighted by their
/// variances.
void estimate_scatter(LevelModel& model) {
  Values sum = Values::Zero(model.n_bands), weights = Values::Constant(model.n_bands, 1e-300);
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    const Values size2 = model.scatter2 + model.relative_noise2.col(k);
    const Values weight = 1.0 / size2.square();
    const Values squares = model.residual.col(k).square() / model.row_inflation[k];
    sum += (squares.min(2.0 * kContact.huber * kContact.huber * size2) - model.relative_noise2.col(k)) * weight;
    weights += weight;
  }
  const Values own = model.active * (sum / weights).max(square(kContact.least_scatter));
  std::vector<double> active;
  for (Eigen::Index m = 0; m < model.n_bands; ++m)
    if (model.active[m] > 0.0) active.push_back(own[m]);
  if (!active.empty()) model.scatter2 = 0.5 * (own + upper_median(std::move(active)));
}

void estimate_row_inflation(LevelModel& model) {
  const double n = model.active.sum();
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    const Values squares = model.residual.col(k).square() / (model.scatter2 + model.relative_noise2.col(k));
    const double sum = dot(squares.min(kContact.most_of_square).eval(), model.active);
    model.row_inflation[k] =
        std::max(1.0, (sum + kContact.inflation_prior) / (n + kContact.inflation_prior) / kContact.typical);
  }
}

/// Residuals, the variance components in them (scatter by band, inflation by impact) and the weights that follow, with
/// Huber's factor for residuals beyond 2.5 standard deviations.
/// Source: Huber, Ann. Math. Stat. 35, 73 (1964), doi:10.1214/aoms/1177703732
void update_weights(LevelModel& model) {
  set_residuals(model);
  estimate_scatter(model);
  estimate_row_inflation(model);
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    const Values variance = model.variance(k);
    const Values near = kContact.huber * variance.sqrt() / (model.residual.col(k).abs() + 1e-300);
    model.weight.col(k) = model.active * near.min(1.0) / variance;
  }
}

constexpr double kStart_s = 30e-6;   // steel on glass; the result does not depend on it
constexpr double kMinTau_s = 5e-6;   // about which the law is linearised in tau^2
constexpr double kMaxTau_s = 50e-3;  // a basketball's is 14 ms
constexpr int kMaxPulseSteps = 25;
constexpr int kFirstRounds = 4;  // of amplitudes and weights, which converge to a thousandth of an error
constexpr int kLaterRounds = 2;  // from those of the last step
constexpr int kPoolingRounds = 10;

/// A step of tau_1^2 and its standard error.
struct PooledEstimate {
  double step = 0.0;
  double sigma = 0.0;
};

/// A step of tau_1^2 by each band alone, and its variance up to a common factor.
struct BandEstimates {
  std::vector<double> step;
  std::vector<double> variance;
};

/// Regression of each band's residuals on d ln P / d tau_1^2, amplitudes and responses taken out of both.
BandEstimates estimates_by_band(const LevelModel& model) {
  BandTable regressor = model.dlogp_dtau2;
  BandTable rest = model.residual;
  demean_two_way(regressor, model.weight);
  demean_two_way(rest, model.weight);
  const Values xy = sums_over_impacts(model.weight * regressor * rest);
  const Values xx = sums_over_impacts(model.weight * regressor * regressor);
  BandEstimates estimates;
  for (Eigen::Index m = 0; m < model.n_bands; ++m) {
    if (!(model.active[m] > 0.0 && xx[m] > 0.0)) continue;
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

}  // namespace

double contact_delay(double v_mps, double reference_scaling) { return 0.5 * (pow(v_mps, -0.2) - reference_scaling); }

ContactLaw assumed_contact(double rms_hz) {
  const double tau_s = kContact.duration_times_frequency / rms_hz;
  return {tau_s, kContact.duration_sigma / rms_hz};
}

ContactLaw pool_contacts(const std::vector<ContactFit>& drops, const ContactLaw& assumed) {
  if (drops.empty()) return assumed;
  const ContactFit pooled = pool(drops);
  ContactLaw law = law_of(with_prior(pooled, assumed));
  law.is_significant = pooled.tau2_s2 > kContact.significant * pooled.sigma2_s2;
  return law;
}

/// Absent also where the bands tell less of the contact time than that it is a ball's, as where a response that noise
/// has made negative is divided by.
std::optional<ContactFit> fit_contact(const BandLevels& levels) {
  if (levels.contact_scaling.size() < kContact.fewest_impacts || levels.f_hz.size() < kContact.fewest_bands)
    return std::nullopt;
  LevelModel model(levels);
  ContactFit fit;
  double tau_1_s = kStart_s;
  for (int step = 0; step < kMaxPulseSteps; ++step) {
    set_pulse(tau_1_s, model);
    for (int round = 0; round < (step == 0 ? kFirstRounds : kLaterRounds); ++round) {
      fit_amplitudes(model);
      update_weights(model);
    }
    const BandEstimates bands = estimates_by_band(model);
    if (bands.step.size() < kContact.fewest_bands) return std::nullopt;
    const PooledEstimate pooled = pool_bands(bands);
    if (!std::isfinite(pooled.step) || !(pooled.sigma > 0.0 && pooled.sigma < square(kMaxTau_s))) return std::nullopt;
    fit = {tau_1_s * tau_1_s + pooled.step, pooled.sigma};
    const double next_s = std::sqrt(std::max(fit.tau2_s2, kMinTau_s * kMinTau_s));
    if (std::abs(next_s * next_s - tau_1_s * tau_1_s) < 0.02 * pooled.sigma) break;
    tau_1_s = std::clamp(next_s, 0.6 * tau_1_s, 1.7 * tau_1_s);
  }
  return fit;
}

}  // namespace bouncelab::detection
