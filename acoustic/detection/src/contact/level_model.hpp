// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "contact/band_levels.hpp"
#include "contact/pulse_spectrum.hpp"

namespace bouncelab::detection {

/// Values by impact (row) and band (column).
class BandTable {
 public:
  BandTable() = default;
  BandTable(std::size_t n_impacts, std::size_t n_bands, double value = 0.0)
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

/// Weighted two-way demeaning: subtracts weighted means of rows and of columns in turns, until those of the columns
/// have fallen to 1e-4 of the first, at most twelve times. What is left is orthogonal to row and column effects (the
/// within transformation of a two-way fixed-effects regression).
/// @param weight  of the size of x, not negative
void demean_two_way(BandTable& x, const BandTable& weight);

/// Model of the levels of a drop's impacts k in bands m,
///
///   level_km = c_k h_m P(f_m tau_1 u_k) (1 + scatter_m) + noise_m,   u_k = v_k^(-1/5)
///
/// with an amplitude c_k for each impact and a response h_m for each band; and the weight of each level in its fit.
struct LevelModel {
  /// @param levels  kept by reference; not empty
  explicit LevelModel(const BandLevels& levels);
  std::size_t n_impacts() const { return amplitude.size(); }
  std::size_t n_bands() const { return response.size(); }
  /// Expected square of a relative residual.
  double variance(std::size_t k, std::size_t m) const {
    return (scatter2[m] + relative_noise2[k][m]) * row_inflation[k];
  }

  const BandLevels& levels;
  BandTable level_over_pulse;         ///< level / P
  BandTable one_over_pulse;           ///< 1 / P, at most 50
  BandTable dlogp_dtau2;              ///< d ln P / d tau_1^2
  BandTable weight;                   ///< of each level
  BandTable residual;                 ///< relative: level / (c h P) - 1
  BandTable relative_noise2;          ///< variance of the noise in it
  std::vector<double> amplitude;      ///< c_k
  std::vector<double> response;       ///< h_m
  std::vector<double> scatter2;       ///< variance of the levels' scatter, by band
  std::vector<double> row_inflation;  ///< factor >= 1 on the variance of impacts at which there was another sound too
  std::vector<bool> is_active;        ///< bands in which P is large enough for the model of the pulse to hold
  std::vector<double> active_mask;    ///< the same as 1 and 0
  bool is_fixed = false;              ///< whether active bands, weights and variances stay as they are
};

/// Sets P and its derivative at a contact time, and the active bands unless the model is fixed.
void set_pulse(const PulseSpectrum& pulse, double tau_1_s, LevelModel& model);

/// Amplitudes and responses that fit the levels best with the present weights: alternately sum w level / (h P) / sum w
/// over bands and sum w level / (c P) / sum w over impacts.
void fit_amplitudes(LevelModel& model);

/// Residuals, the variance components in them (scatter by band, inflation by impact) and the weights that follow, with
/// Huber's factor for residuals beyond 2.5 standard deviations; of a fixed model the residuals alone.
/// Source: Huber, Ann. Math. Stat. 35, 73 (1964), doi:10.1214/aoms/1177703732
void update_weights(LevelModel& model);

/// Huber's threshold, in standard deviations.

}  // namespace bouncelab::detection
