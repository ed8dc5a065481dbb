// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {

inline constexpr std::size_t kMaxSubbands = 10;  // of one wave

/// Least share of its variance that a subband's deviations from the mean keep: the mean follows none altogether.
inline constexpr double kMinResidualShare = 0.2;

/// Bands of a wave's spectrum, each a subband of its own that says when an impact was.
///
/// A band's time errs by the noise, with variance noise / (amplitude^2 sum omega^2 |wave|^2), and by the modes in it
/// that are struck differently each time, with the variance `jitter2`, whatever the amplitude. How far the subbands
/// disagree over the impacts of a recording tells the latter: what no residual of a fit shows, since a fit takes the
/// part of a residual_variance that looks like a shift for a shift.
struct Subbands {
  std::vector<std::size_t> edge;  ///< bins; band j is edge[j] ... edge[j+1] - 1
  std::vector<double> noise;      ///< variance of the noise in each real and imaginary part
  std::vector<double> jitter2;    ///< [samples^2]
  double correlation = 0.0;       ///< of the jitter of neighbours; of subbands further apart its power
  std::size_t n_learned = 0;      ///< impacts that the jitter is known from; 0 = it is known
  std::size_t n() const { return noise.size(); }
};

/// A wave and what its bands know.
class MatchedFilter {
 public:
  MatchedFilter() = default;
  /// @param n_window  samples of the window that the spectrum is of
  MatchedFilter(audio::Spectrum wave, std::size_t n_window);

  const audio::Spectrum& wave() const { return wave_; }
  std::size_t n_window() const { return n_window_; }
  double energy() const { return energy_; }
  /// 2 pi / n_window
  double omega() const { return omega_; }
  /// Root mean square frequency [cycles per sample]; at least 1e-6.
  double rms_frequency() const;
  /// sum |wave|^2 and sum omega^2 |wave|^2 over bins from ... to - 1
  double energy(std::size_t from, std::size_t to) const { return running_[to] - running_[from]; }
  double information(std::size_t from, std::size_t to) const {
    return running_information_[to] - running_information_[from];
  }

 private:
  audio::Spectrum wave_;
  std::size_t n_window_ = 0;
  double omega_ = 0.0;
  double energy_ = 0.0;
  std::vector<double> running_;
  std::vector<double> running_information_;
};

/// Up to ten bands of about equal information on the time, parted where the spectrum is low, so that no mode is told by
/// two subbands; noise 1 and jitter 0.
Subbands split_into_subbands(const MatchedFilter& wave);

/// The mean of an impact's subbands, weighted by their variances, and how each subband goes with it.
struct SubbandMean {
  double variance = 0.0;                      ///< of the mean
  double design_effect = 1.0;                 ///< its variance over what it were if the subbands were independent
  std::array<double, kMaxSubbands> weight{};  ///< in the mean; the sum is 1
  std::array<double, kMaxSubbands> jitter{};  ///< share of each subband's variance
  std::array<double, kMaxSubbands>
      relative_covariance{};  ///< covariance of each with the mean over what it were if independent
};

/// Noise is independent from subband to subband, jitter is correlated like rho^lag.
SubbandMean subband_mean(const Subbands& subbands, const std::vector<double>& noise_variance);

/// What the subbands say of one impact.
struct DelayEstimate {
  double shift = 0.0;                  ///< of the wave within the window [samples]
  double amplitude = 0.0;              ///< in units of the wave
  double log_likelihood_ratio = 0.0;   ///< log likelihood ratio against no impact, noise variance 1
  double variance = 0.0;               ///< of the shift [samples^2]
  std::vector<double> deviation;       ///< each subband's time minus `shift`
  std::vector<double> noise_variance;  ///< of each subband's time, without jitter
};

/// Reads all subbands and takes their mean, weighted by their variances, from a start within half a cycle.
///
///   x_j = Re sum conj(W) Y e^(i omega s),  d_j = -sum omega Im(conj(W) Y e^(i omega s)),  time_j = s + d_j / (A I_j)
///
/// by Gauss and Newton; the variance follows how far the subbands disagree, (8 + chi2) / (8 + n - 1) of what is
/// expected.
DelayEstimate estimate_delay(const MatchedFilter& wave, const Subbands& subbands, const audio::Spectrum& sound,
                             double start);

}  // namespace bouncelab::detection
