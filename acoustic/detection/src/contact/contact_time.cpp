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

struct Band {
  std::size_t from = 0;
  std::size_t to = 0;   // bins from ... to - 1
  double energy = 0.0;  // of the template
  double noise = 0.0;   // variance in each real and imaginary part
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
  for (std::size_t b = 1; b + width <= n_bins; b += width)
    all.push_back(
        {b, b + width, learned.filter.energy(b, b + width) + 1e-30, noise_at(learned.subbands, b + width / 2)});
  std::vector<Band> bands;
  for (std::size_t m = 0; m < all.size(); ++m) {
    std::vector<double> around;
    for (std::size_t c = m > kContact.neighbours ? m - kContact.neighbours : 0;
         c < std::min(m + kContact.neighbours + 1, all.size()); ++c)
      around.push_back(all[c].energy);
    const std::size_t lower_middle = (around.size() - 1) / 2;
    const double noise_energy = 2.0 * all[m].noise * static_cast<double>(width) / learned.training_weight;
    if (all[m].energy >= order_statistic(std::move(around), lower_middle) &&
        all[m].energy >= kContact.least_template_snr * noise_energy)
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
  for (const TimedImpact& impact : impacts) {
    if (!(impact.fit.amplitude > 0.0)) continue;
    const double position = impact.fit.t_s * rate_hz - learned.contact_index;
    const auto first = static_cast<std::int64_t>(std::floor(position));
    white.read(learned.whitener, first, window);  // zeros follow
    const audio::Spectrum in_phase =
        audio::phase_shifted(audio::product_conj(learned.filter.spectrum(), fourier.forward(window)),
                             learned.filter.omega() * (position - static_cast<double>(first)));
    std::vector<double> row;
    for (const Band& band : bands)
      row.push_back(std::accumulate(in_phase.re.begin() + static_cast<std::ptrdiff_t>(band.from),
                                    in_phase.re.begin() + static_cast<std::ptrdiff_t>(band.to), 0.0) /
                    band.energy);
    levels.contact_scaling.push_back(pow(impact.v_mps, -0.2));
    levels.level.push_back(std::move(row));
  }
  return levels;
}

namespace {

constexpr double kLargestArgument = 4.0;  // of the spectrum
constexpr double kPerUnit = 32.0;         // a cubic between two is the spectrum to 1e-7

/// Of Hertz's pulse, with its slope, in steps of 1 / kPerUnit.
std::vector<PulseSpectrum> tabulated_pulse() {
  const PointImpulses pulse = hertz_impulses(2.0 * kLargestArgument);
  std::vector<PulseSpectrum> table(static_cast<std::size_t>(kLargestArgument * kPerUnit) + 1);
  for (std::size_t k = 0; k < table.size(); ++k)
    for (std::size_t q = 0; q < pulse.nodes.size(); ++q) {
      const double omega = 2.0 * kPi * (pulse.nodes[q] - 0.5), x = static_cast<double>(k) / kPerUnit;
      table[k].value += pulse.weights[q] * cos(omega * x);
      table[k].slope -= pulse.weights[q] * omega * sin(omega * x);
    }
  return table;
}

}  // namespace

PulseSpectrum pulse_spectrum(double x) {
  static const std::vector<PulseSpectrum> table = tabulated_pulse();
  const double place = x * kPerUnit;
  const auto index = static_cast<std::size_t>(place);
  if (index + 1 >= table.size()) return {};
  const double t = place - static_cast<double>(index);
  const PulseSpectrum &a = table[index], &b = table[index + 1];
  const double rise = b.value - a.value, begin = a.slope / kPerUnit, end = b.slope / kPerUnit;
  const double square = 3.0 * rise - 2.0 * begin - end, cube = begin + end - 2.0 * rise;
  return {a.value + t * (begin + t * (square + t * cube)), kPerUnit * (begin + t * (2.0 * square + 3.0 * t * cube))};
}

namespace {

/// Weighted mean; its standard error grows with a scatter beyond the stated ones.
ContactFit weighted_mean(const std::vector<ContactFit>& fits) {
  double sum = 0.0, weights = 0.0, chi2 = 0.0;
  for (const ContactFit& fit : fits) sum += fit.tau2_s2 / square(fit.sigma2_s2), weights += 1.0 / square(fit.sigma2_s2);
  for (const ContactFit& fit : fits) chi2 += square((fit.tau2_s2 - sum / weights) / fit.sigma2_s2);
  const double scatter = std::max(1.0, chi2 / std::max(1.0, static_cast<double>(fits.size()) - 1.0));
  return {sum / weights, std::sqrt(scatter / weights)};
}

/// Values by band (row) and impact (column).
using BandTable = Eigen::ArrayXXd;
using Values = Eigen::ArrayXd;

/// Sum of products, in the same order on all processors.
template <class A, class B>
double dot(const A& a, const B& b) {
  return audio::dot(a.data(), b.data(), static_cast<std::size_t>(a.size()));
}

struct Means {
  Values of_impact, of_band;
};

/// Weighted two-way demeaning: subtracts weighted means of impacts and of bands in turns. What is left is orthogonal to
/// the effects of both (the within transformation of a two-way fixed-effects regression).
/// @return what was subtracted
Means demean_two_way(BandTable& x, const BandTable& weight) {
  constexpr int kRounds = 2;
  Values per_impact(x.cols()), sum = Values::Constant(x.rows(), 1e-300);
  const Values ones = Values::Ones(x.rows());
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    per_impact[k] = 1.0 / (dot(weight.col(k), ones) + 1e-300);
    sum += weight.col(k);
  }
  Means all{Values::Zero(x.cols()), Values::Zero(x.rows())};
  for (int round = 0; round < kRounds; ++round) {
    Values means = Values::Zero(x.rows());
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      const double mean = per_impact[k] * dot(weight.col(k), x.col(k));
      x.col(k) -= mean;
      all.of_impact[k] += mean;
      means += weight.col(k) * x.col(k);
    }
    means /= sum;
    x.colwise() -= means;
    all.of_band += means;
  }
  return all;
}

/// The levels of a drop against the model at a contact time, in the lowest bands, where the model of the pulse holds at
/// all impacts.
struct LevelModel {
  explicit LevelModel(const BandLevels& of) : levels(of) {
    for (std::size_t k = 0; k < of.level.size(); ++k)
      amplitude[static_cast<Eigen::Index>(k)] = std::max(
          std::accumulate(of.level[k].begin(), of.level[k].end(), 0.0) / static_cast<double>(of.f_hz.size()), 1e-9);
  }

  const BandLevels& levels;
  Eigen::Index n_impacts = static_cast<Eigen::Index>(levels.contact_scaling.size());
  double slowest = *std::max_element(levels.contact_scaling.begin(), levels.contact_scaling.end());
  Values amplitude = Values::Ones(n_impacts);                                     // c_k
  Values response = Values::Ones(static_cast<Eigen::Index>(levels.f_hz.size()));  // h_m, of all bands
  double scatter2 = 0.1;  // variance of the levels about the model, relative; where the fit begins
  BandTable slope;        // d ln P / d tau_1^2
  BandTable residual;     // relative: level / (c h P) - 1
  BandTable noise2;       // variance of the noise in it
  BandTable weight;       // of each residual
};

void set_residuals(double tau_1_s, LevelModel& model) {
  const BandLevels& l = model.levels;
  std::size_t n_bands = 0;
  while (n_bands < l.f_hz.size() && l.f_hz[n_bands] * tau_1_s * model.slowest < kContact.most_argument) ++n_bands;
  for (BandTable* table : {&model.slope, &model.residual, &model.noise2, &model.weight})
    table->resize(static_cast<Eigen::Index>(n_bands), model.n_impacts);
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    const std::size_t impact = static_cast<std::size_t>(k);
    const double duration_s = tau_1_s * l.contact_scaling[impact];
    for (std::size_t band = 0; band < n_bands; ++band) {
      const Eigen::Index m = static_cast<Eigen::Index>(band);
      const double x = l.f_hz[band] * duration_s;
      const auto [value, slope] = pulse_spectrum(x);
      const double per_level = 1.0 / (model.amplitude[k] * model.response[m] * value);
      model.slope(m, k) = slope * x / (2.0 * square(tau_1_s) * value);
      model.residual(m, k) = l.level[impact][band] * per_level - 1.0;
      model.noise2(m, k) = l.noise2[band] * square(per_level);
    }
  }
}

/// The scatter, by what the squares of the residuals have beyond the noise, and the weights that follow, with Huber's
/// factor for large residuals.
/// Source: Huber, Ann. Math. Stat. 35, 73 (1964), doi:10.1214/aoms/1177703732
void set_weights(LevelModel& model) {
  const BandTable before = model.scatter2 + model.noise2;
  model.weight = 1.0 / before.square();
  const BandTable excess = model.residual.square().min(2.0 * square(kContact.huber) * before) - model.noise2;
  const double mean =
      dot(model.weight, excess) / dot(model.weight, BandTable::Ones(excess.rows(), excess.cols()).eval());
  model.scatter2 = std::max(mean, square(kContact.least_scatter));
  const BandTable variance = model.scatter2 + model.noise2;
  model.weight = (kContact.huber * variance.sqrt() / (model.residual.abs() + 1e-300)).min(1.0) / variance;
}

constexpr double kMinTau_s = 5e-6;   // about which the law is linearised in tau^2
constexpr double kMaxTau_s = 50e-3;  // a basketball's is 14 ms
constexpr double kMostGrowth = 1.5;  // of tau in a step
constexpr int kMostSteps = 40;

/// Gauss-Newton step of tau_1, amplitudes and responses. A mode whose level drifts over the drop is one deviation and
/// not as many as there are impacts: the scatter between bands sets the error.
/// @return the whole step of tau_1^2, of which a part may have been taken, and its standard error
ContactFit take_step(double& tau_1_s, LevelModel& model) {
  const Eigen::Index n_bands = model.residual.rows();
  const Means of_residual = demean_two_way(model.residual, model.weight);
  const Means of_slope = demean_two_way(model.slope, model.weight);
  Values xy = Values::Zero(n_bands), xx = Values::Constant(n_bands, 1e-300);
  for (Eigen::Index k = 0; k < model.n_impacts; ++k) {
    xy += model.weight.col(k) * model.slope.col(k) * model.residual.col(k);
    xx += model.weight.col(k) * model.slope.col(k).square();
  }
  const Values ones = Values::Ones(n_bands);
  const double sum_xx = dot(xx, ones), step = dot(xy, ones) / sum_xx;
  const double chi2 = dot(((xy - step * xx).square() / xx).eval(), ones);
  const double before = square(tau_1_s), next_s = std::sqrt(std::max(before + step, square(kMinTau_s)));
  tau_1_s = std::clamp(next_s, tau_1_s / kMostGrowth, tau_1_s * kMostGrowth);
  const double taken = square(tau_1_s) - before;
  model.amplitude *= (1.0 + of_residual.of_impact - taken * of_slope.of_impact).max(0.1);
  model.response.head(n_bands) *= (1.0 + of_residual.of_band - taken * of_slope.of_band).max(0.1);
  // the amplitudes take one more degree of freedom
  return {step, std::sqrt(std::max(1.0, chi2 / (static_cast<double>(n_bands) - 2.0)) / sum_xx)};
}

}  // namespace

double contact_delay(double v_mps, double reference_scaling) { return 0.5 * (pow(v_mps, -0.2) - reference_scaling); }

ContactLaw assumed_contact(double rms_hz) {
  const double tau_s = kContact.duration_times_frequency / rms_hz;
  return {tau_s, kContact.duration_sigma / rms_hz};
}

ContactLaw pool_contacts(const std::vector<ContactFit>& drops, const ContactLaw& assumed) {
  if (drops.empty()) return assumed;
  ContactFit fit = weighted_mean(drops);
  const bool is_significant = fit.tau2_s2 > kContact.significant * fit.sigma2_s2;
  const ContactFit prior{square(assumed.tau_1_s), 2.0 * assumed.tau_1_s * assumed.sigma_s};
  if (std::abs(fit.tau2_s2 - prior.tau2_s2) <= kContact.most_difference * hypot(fit.sigma2_s2, prior.sigma2_s2))
    fit = weighted_mean({fit, prior});
  const double tau2_s2 = std::max(fit.tau2_s2, 0.0), tau_s = std::sqrt(tau2_s2);
  return {tau_s, std::sqrt(tau2_s2 + fit.sigma2_s2) - tau_s, is_significant};
}

std::optional<ContactFit> fit_contact(const BandLevels& levels) {
  if (levels.contact_scaling.size() < kContact.fewest_impacts || levels.f_hz.size() < kContact.fewest_bands)
    return std::nullopt;
  LevelModel model(levels);
  ContactFit fit;
  double tau_1_s = 0.99 * kContact.most_argument / (model.slowest * levels.f_hz[kContact.fewest_bands - 1]);
  for (int step = 0; step < kMostSteps; ++step) {
    set_residuals(tau_1_s, model);
    if (model.residual.rows() < static_cast<Eigen::Index>(kContact.fewest_bands)) return std::nullopt;
    set_weights(model);
    const double before = square(tau_1_s);
    fit = take_step(tau_1_s, model);
    if (!std::isfinite(fit.tau2_s2) || !(fit.sigma2_s2 > 0.0 && fit.sigma2_s2 < square(kMaxTau_s))) return std::nullopt;
    const bool is_last = std::abs(fit.tau2_s2) < 0.05 * fit.sigma2_s2;
    fit.tau2_s2 += before;
    if (is_last) break;
  }
  return fit;
}

}  // namespace bouncelab::detection
