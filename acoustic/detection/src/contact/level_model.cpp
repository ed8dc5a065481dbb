// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/level_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/numerics.hpp"
#include "contact/contact_model.hpp"

namespace bouncelab::detection {
namespace {

std::vector<double> sums_of_rows(const BandTable& x) {
  const std::vector<double> ones(x.n_bands(), 1.0);
  std::vector<double> sums(x.n_impacts());
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = audio::dot(x[k], ones.data(), x.n_bands());
  return sums;
}

std::vector<double> sums_of_columns(const BandTable& x) {
  std::vector<double> sums(x.n_bands(), 0.0);
  for (std::size_t k = 0; k < x.n_impacts(); ++k) audio::add_scaled(sums.data(), 1.0, x[k], x.n_bands());
  return sums;
}

/// One round: subtracts weighted means of rows, then of columns.
/// @param per_row, per_column  1 / sum of the weights
/// @return sum of squares of the means of columns
double demean_once(BandTable& x, const BandTable& weight, const std::vector<double>& per_row,
                   const std::vector<double>& per_column) {
  const std::size_t n = x.n_bands();
  std::vector<double> means(n, 0.0);
  for (std::size_t k = 0; k < x.n_impacts(); ++k) {
    double* const row = x[k];
    const double* const w = weight[k];
    const double mean = per_row[k] * audio::dot(w, row, n);
    for (std::size_t m = 0; m < n; ++m) {
      row[m] -= mean;
      means[m] += w[m] * row[m];
    }
  }
  for (std::size_t m = 0; m < n; ++m) means[m] *= per_column[m];
  for (std::size_t k = 0; k < x.n_impacts(); ++k) audio::add_scaled(x[k], -1.0, means.data(), n);
  return audio::dot(means.data(), means.data(), n);
}

using Values = std::vector<double>;

// The loops over the bands of one impact. All are elementwise.

/// @param one_over_pulse, dlogp_dtau2  hold P and its slope before
void divide_by_pulse(const double* level, const double* f_hz, double half_u_over_tau, const double* active,
                     double* __restrict one_over_pulse, double* __restrict dlogp_dtau2,
                     double* __restrict level_over_pulse, double* __restrict weight, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    const double one_over = 1.0 / (one_over_pulse[m] > 0.02 ? one_over_pulse[m] : 0.02);
    one_over_pulse[m] = one_over;
    dlogp_dtau2[m] *= half_u_over_tau * f_hz[m] * one_over;
    level_over_pulse[m] = level[m] * one_over;
    weight[m] = active[m] * (weight[m] > 1e-12 ? weight[m] : 1e-12);
  }
}

void relative_residuals(double one_over_amplitude, const double* one_over_response, const double* one_over_pulse,
                        const double* level_over_pulse, const double* level_noise2, double* __restrict residual,
                        double* __restrict noise2, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    const double scale = one_over_amplitude * one_over_response[m];
    const double unit = scale * one_over_pulse[m];
    residual[m] = scale * level_over_pulse[m] - 1.0;
    noise2[m] = level_noise2[m] * unit * unit;
  }
}

/// Adds what the squares of the residuals have beyond the noise, weighted by their variances.
void add_excess(const double* residual, const double* noise2, const double* scatter2, double row_inflation,
                double* __restrict sum, double* __restrict weights, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    const double size2 = scatter2[m] + noise2[m];
    const double weight = 1.0 / (size2 * size2);
    const double largest = 2.0 * kContact.huber * kContact.huber * size2;
    const double square = residual[m] * residual[m] / row_inflation;
    sum[m] += ((square < largest ? square : largest) - noise2[m]) * weight;
    weights[m] += weight;
  }
}

void limited_squares(const double* residual, const double* noise2, const double* scatter2, double* __restrict squares,
                     std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    const double square = residual[m] * residual[m] / (scatter2[m] + noise2[m]);
    squares[m] = square < kContact.most_of_square ? square : kContact.most_of_square;
  }
}

void huber_weights(const double* residual, const double* noise2, const double* scatter2, const double* active,
                   double row_inflation, double* __restrict weight, std::size_t n) {
  for (std::size_t m = 0; m < n; ++m) {
    const double size2 = (scatter2[m] + noise2[m]) * row_inflation;
    const double near = kContact.huber * std::sqrt(size2) / (std::abs(residual[m]) + 1e-300);
    weight[m] = active[m] * (near < 1.0 ? near : 1.0) / size2;
  }
}

Values inverse(Values x) {
  for (double& value : x) value = 1.0 / value;
  return x;
}

void set_residuals(LevelModel& model) {
  const Values one_over_response = inverse(model.response);
  for (std::size_t k = 0; k < model.n_impacts(); ++k)
    relative_residuals(1.0 / model.amplitude[k], one_over_response.data(), model.one_over_pulse[k],
                       model.level_over_pulse[k], model.levels.noise2.data(), model.residual[k],
                       model.relative_noise2[k], model.n_bands());
}

/// Scatter of each band, half its own and half the median one: the own estimate of a band that happened to scatter
/// little would give it too much weight.
void estimate_scatter(LevelModel& model) {
  const std::size_t n = model.n_bands();
  Values sum(n, 0.0), weights(n, 1e-300);
  for (std::size_t k = 0; k < model.n_impacts(); ++k)
    add_excess(model.residual[k], model.relative_noise2[k], model.scatter2.data(), model.row_inflation[k], sum.data(),
               weights.data(), n);
  Values active;
  for (std::size_t m = 0; m < n; ++m) {
    sum[m] = model.is_active[m] ? std::max(sum[m] / weights[m], kContact.least_scatter * kContact.least_scatter) : 0.0;
    if (model.is_active[m]) active.push_back(sum[m]);
  }
  if (active.empty()) return;
  const double median = upper_median(std::move(active));
  for (std::size_t m = 0; m < n; ++m) model.scatter2[m] = 0.5 * (sum[m] + median);
}

void estimate_row_inflation(LevelModel& model) {
  const double n = std::accumulate(model.active_mask.begin(), model.active_mask.end(), 0.0);
  Values squares(model.n_bands());
  for (std::size_t k = 0; k < model.n_impacts(); ++k) {
    limited_squares(model.residual[k], model.relative_noise2[k], model.scatter2.data(), squares.data(),
                    model.n_bands());
    const double sum = audio::dot(squares.data(), model.active_mask.data(), model.n_bands());
    model.row_inflation[k] =
        std::max(1.0, (sum + kContact.inflation_prior) / (n + kContact.inflation_prior) / kContact.typical);
  }
}

}  // namespace

void demean_two_way(BandTable& x, const BandTable& weight) {
  constexpr int kMaxRounds = 12;
  constexpr double kConverged = 1e-8;  // of the sum of squares of the first round
  std::vector<double> per_row = sums_of_rows(weight);
  std::vector<double> per_column = sums_of_columns(weight);
  for (double& sum : per_row) sum = 1.0 / (sum + 1e-300);
  for (double& sum : per_column) sum = 1.0 / (sum + 1e-300);
  double first = 0.0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double squares = demean_once(x, weight, per_row, per_column);
    if (round == 0) first = squares;
    if (squares <= kConverged * first) break;
  }
}

LevelModel::LevelModel(const BandLevels& of)
    : levels(of),
      level_over_pulse(of.contact_scaling.size(), of.f_hz.size()),
      one_over_pulse(level_over_pulse),
      dlogp_dtau2(level_over_pulse),
      weight(of.contact_scaling.size(), of.f_hz.size(), 1.0),
      residual(level_over_pulse),
      relative_noise2(level_over_pulse),
      amplitude(of.contact_scaling.size(), 1.0),
      response(of.f_hz.size(), 1.0),
      scatter2(of.f_hz.size(), 0.1),
      row_inflation(of.contact_scaling.size(), 1.0),
      is_active(of.f_hz.size(), false),
      active_mask(of.f_hz.size(), 0.0) {
  for (std::size_t k = 0; k < n_impacts(); ++k) {
    const Values& row = of.level[k];
    amplitude[k] = std::max(std::accumulate(row.begin(), row.end(), 0.0) / static_cast<double>(n_bands()), 1e-9);
  }
}

void set_pulse(const PulseSpectrum& pulse, double tau_1_s, LevelModel& model) {
  const BandLevels& l = model.levels;
  const double largest_scaling = *std::max_element(l.contact_scaling.begin(), l.contact_scaling.end());
  for (std::size_t m = 0; m < model.n_bands(); ++m) {
    const double largest = l.f_hz[m] * tau_1_s * largest_scaling;
    if (!model.is_fixed)
      model.is_active[m] = pulse.at(largest).value > kContact.least_pulse && largest < kContact.most_argument;
    model.active_mask[m] = model.is_active[m] ? 1.0 : 0.0;
  }
  for (std::size_t k = 0; k < model.n_impacts(); ++k) {
    for (std::size_t m = 0; m < model.n_bands(); ++m) {
      const auto [value, slope] = pulse.at(l.f_hz[m] * l.contact_scaling[k] * tau_1_s);
      model.one_over_pulse[k][m] = value;
      model.dlogp_dtau2[k][m] = slope;
    }
    divide_by_pulse(l.level[k].data(), l.f_hz.data(), 0.5 * l.contact_scaling[k] / tau_1_s, model.active_mask.data(),
                    model.one_over_pulse[k], model.dlogp_dtau2[k], model.level_over_pulse[k], model.weight[k],
                    model.n_bands());
  }
}

void fit_amplitudes(LevelModel& model) {
  const std::size_t n_impacts = model.n_impacts(), n_bands = model.n_bands();
  BandTable weighted(n_impacts, n_bands);
  for (std::size_t k = 0; k < n_impacts; ++k)
    audio::multiply(model.weight[k], model.level_over_pulse[k], weighted[k], n_bands);
  const Values weight_of_row = sums_of_rows(model.weight);
  const Values weight_of_column = sums_of_columns(model.weight);
  for (int round = 0; round < 3; ++round) {
    const Values one_over_response = inverse(model.response);
    Values sums(n_bands, 0.0);
    for (std::size_t k = 0; k < n_impacts; ++k) {
      double& c = model.amplitude[k];
      c = std::max(audio::dot(weighted[k], one_over_response.data(), n_bands) / (weight_of_row[k] + 1e-300), 0.1 * c);
      audio::add_scaled(sums.data(), 1.0 / c, weighted[k], n_bands);
    }
    for (std::size_t m = 0; m < n_bands; ++m)
      if (model.is_active[m])
        model.response[m] = std::max(sums[m] / (weight_of_column[m] + 1e-300), 0.1 * model.response[m]);
  }
}

void update_weights(LevelModel& model) {
  set_residuals(model);
  if (model.is_fixed) return;
  estimate_scatter(model);
  estimate_row_inflation(model);
  for (std::size_t k = 0; k < model.n_impacts(); ++k)
    huber_weights(model.residual[k], model.relative_noise2[k], model.scatter2.data(), model.active_mask.data(),
                  model.row_inflation[k], model.weight[k], model.n_bands());
}

}  // namespace bouncelab::detection
