// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "timing/correlation_peaks.hpp"
#include "timing/cycle_ambiguity.hpp"
#include "timing/impact_template.hpp"

namespace bouncelab::detection {

/// An impact timed by maximum likelihood.
struct TimedImpact {
  double t_s = 0.0;
  double sigma_s = 0.0;
  double amplitude = 0.0;             ///< in units of the wave
  double log_likelihood_ratio = 0.0;  ///< log likelihood ratio against no impact there, noise variance 1
  double residual_variance = 0.0;     ///< mean square residual, noise = 1
  double noise = 1.0;                 ///< variance of the noise there, as the whitener leaves it; at least 1
  double correlation = 0.0;           ///< of the sound with the wave, 0 ... 1
  std::vector<DelayHypothesis>
      others;  ///< where else it may have been, cycles off; none where the sound has settled it
};

/// Times impacts one after the other, what still rings of the earlier ones subtracted.
class ImpactTimer {
 public:
  /// @param sound, wave  kept by reference
  ImpactTimer(const audio::AudioSource& sound, const ImpactTemplate& wave);

  /// The most likely impact within reach_s of t_s. Does not subtract_from_later it.
  /// @param until_s  sound from here on belongs to the next impact
  TimedImpact time(double t_s, double reach_s, double until_s);
  /// From now on its ringing is subtracted. Impacts come in time order.
  void subtract_from_later(const TimedImpact& impact);

 private:
  struct Ringing {
    TimedImpact impact;
    std::int64_t first = 0;   // sample at which the window begins
    std::vector<float> wave;  // placed in it; made when first needed
  };
  /// What of a window counts: factors of its samples; empty = all of it.
  using Mask = std::vector<float>;
  /// A window of the sound and where in it the impact may be.
  struct FitWindow {
    std::int64_t first = 0;  // sample at which it begins
    std::size_t n_fit = 0;   // samples of it that belong to this impact
    Mask mask;
    std::vector<float> sound;
    double total = 0.0;  // sum of squares
    audio::Spectrum spectrum;
    std::vector<CorrelationPeak> places;
  };
  /// @param end  sample from which on the sound belongs to the next impact
  FitWindow cut(std::int64_t first, std::int64_t end);
  std::vector<CorrelationPeak> peaks_in(const FitWindow& c, double from, double to);
  /// Mean square of what an impact of so much gain leaves of a window.
  double residual_variance(const FitWindow& c, double log_likelihood_ratio) const;
  /// The subbands at the best of its places.
  DelayEstimate read_cut(const FitWindow& c);
  /// The first n_fit samples.
  Mask beginning(std::size_t n_fit) const;
  bool is_clipped(std::int64_t first) const;
  /// What the converter makes of a wave so loud: limited as recorded, then whitened.
  MatchedFilter clipped_wave(double amplitude, double shift, const Mask& mask);
  /// Time of a clipped impact by the zeros of its sound and by what is below the limit, its amplitude by how long it is
  /// beyond it.
  /// @param total  sum of squares of the window
  DelayEstimate read_clipped(const audio::Spectrum& y, double total, double shift, const Mask& mask);
  std::vector<float> read(std::int64_t first, const Mask& mask);
  /// The wave as far as it counts.
  MatchedFilter masked_wave(double shift, const Mask& mask);

  const audio::AudioSource& sound_;
  const ImpactTemplate& wave_;
  audio::RealFft fourier_;
  double noise_;
  std::vector<Ringing> timed_;
};

}  // namespace bouncelab::detection
