// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "template/subband_delay.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {

/// The sound of known impacts, x(t) = sum_i A_i w_i(t - t_i) in the whitened sound, to be subtracted from the windows
/// of others.
class Ringing {
 public:
  /// @param white, learned  kept by reference
  Ringing(WhiteSound& white, const ImpactTemplate& learned);

  void add(double t_s, double amplitude);
  void set(std::size_t k, double t_s, double amplitude);
  double amplitude(std::size_t k) const { return impacts_[k].amplitude; }

  /// The whitened window that begins at a sample, less the sound of all known impacts but one.
  std::vector<float> window_without(std::int64_t first, std::optional<std::size_t> except = std::nullopt);

  /// Sets the amplitudes of impacts whose windows overlap, jointly, to those of least squares: normal equations
  /// sum_j <w_i, w_j> A_j = <w_i, x>, banded since only neighbours overlap. Those of no others change.
  /// @param free  of each impact, in time order, whether its amplitude is one of the unknowns
  void fit_amplitudes(const std::vector<bool>& free);

 private:
  struct Known {
    double t_s = 0.0;
    double amplitude = 0.0;
    std::int64_t first = 0;     // sample at which its window begins
    std::vector<float> placed;  // its sound there for the amplitude 1; computed when first needed
  };
  const std::vector<float>& placed(Known& impact);

  WhiteSound& white_;
  const ImpactTemplate& learned_;
  audio::RealFft fourier_;
  std::vector<Known> impacts_;
};

/// Times single impacts by maximum likelihood, the ringing of known ones subtracted.
///
/// Model of a window of whitened sound: y(t) = sum_i A_i w(t - t_i) + A w(t - t_0) + white noise, with the template w,
/// the known impacts i, and A, t_0 to be estimated. Of a window that reaches the next impact only the part before it
/// is used.
/// Source: Kay, Fundamentals of Statistical Signal Processing: Estimation Theory (1993), ch. 3, 7.
class ImpactTimer {
 public:
  /// @param white, learned  kept by reference
  ImpactTimer(WhiteSound& white, const ImpactTemplate& learned);

  /// The most likely impact within reach_s of t_s, whether or not there is one (log_likelihood_ratio).
  /// @param until_s  sound from here on belongs to the next impact
  /// @param least    log likelihood ratio; where there is less in the window from t_s on, nothing is returned
  ImpactFit time(double t_s, double reach_s, double until_s, double least = 0.0);
  /// The same by several windows where the reach is wider than step_s(): one that begins after an impact misses its
  /// strongest part.
  ImpactFit search(double t_s, double reach_s, double until_s);
  /// Makes an impact known: later calls of time() subtract its ringing. In any order; one of amplitude 0 adds nothing.
  void subtract_from_later(const ImpactFit& impact) { known_.add(impact.t_s, impact.amplitude); }
  /// Variance of the noise in quiet windows, that of a perfect whitener being 1; in lossy sound it may be far below.
  double noise() const { return noise_; }
  const ImpactTemplate& learned() const { return learned_; }
  double rate_hz() const { return sound_.rate_hz; }
  /// Duration of the template.
  double template_s() const { return static_cast<double>(learned_.n_template) / rate_hz(); }
  /// Step of a search that is wider than the template.
  double step_s() const { return 0.25 * template_s(); }

 private:
  /// Factors of a window's samples; empty = all are 1.
  using Mask = std::vector<float>;
  /// A window of the sound and where in it the impact may be.
  struct FitWindow {
    std::int64_t first = 0;  // sample at which it begins
    std::size_t n_fit = 0;   // samples of it that belong to this impact
    Mask mask;
    std::vector<float> sound;
    double total = 0.0;  // sum of squares
    audio::Spectrum spectrum;
  };
  /// @param end  sample from which on the sound belongs to the next impact
  FitWindow cut(std::int64_t first, std::int64_t end);
  Correlation correlation_in(const FitWindow& window, double from, double to) const;
  /// Samples that hold sound.
  double n_of(const FitWindow& window) const;
  /// Mean square of what an impact leaves of a window at the frequencies of the template, weighted by its energy: what
  /// disturbs the product with it. A codec leaves its errors just there.
  double residual_in_product(const FitWindow& window, const DelayEstimate& r) const;
  /// @param shift  of the highest peak of its correlation
  DelayEstimate estimate_in(const FitWindow& window, double shift) const;
  ImpactFit fit_of(const FitWindow& window, const Correlation& products) const;
  /// 1 for the first n_fit samples, with a tapered end.
  Mask mask_of(std::size_t n_fit) const;
  /// The template at a shift, as much as the mask leaves of it.
  audio::Spectrum placed(double shift, const Mask& mask) const;

  const audio::AudioSource& sound_;
  const ImpactTemplate& learned_;
  audio::RealFft fourier_;
  double noise_;
  Ringing known_;
};

}  // namespace bouncelab::detection
