// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "bouncelab/audio/dsp/white_window.hpp"
#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// A wave is learned from impacts that are not clipped where there are so many of them.
inline constexpr std::ptrdiff_t kFewestWhole = 5;

/// An impact whose time is known to a millisecond or better.
struct RoughImpact {
  double t_s = 0.0;
  double amplitude = 0.0;  ///< any unit, the same for all
  double reach_s = 1e-3;   ///< how far from t_s it may lie
  bool clipped = false;    ///< learned from only where too few others are
};

/// The sound of an impact, whitened by the noise, as learned from the recording.
struct ImpactTemplate {
  std::vector<float> whitener;  ///< filter that makes the noise white with variance 1
  MatchedFilter wave;
  Subbands subbands;
  std::size_t n_template = 0;        ///< samples from the window's first after which the wave is quiet
  double contact_index = 0.0;        ///< start of contact, in samples from the window's first
  double correlation = 0.0;          ///< median of the learned impacts with the wave
  std::int64_t n_impacts = 0;        ///< learned from
  std::vector<double> training_t_s;  ///< when they were
  double training_weight = 0.0;      ///< sum of their squared amplitudes, in units of the wave
  std::vector<double> waveform;      ///< the mean wave as recorded, not whitened
  std::vector<double> spread;        ///< its standard deviation from impact to impact
  double peak = 0.0;                 ///< of `heard`
  float clip_level = INFINITY;       ///< of the sound as recorded; samples at or beyond it are not to be believed
};

/// Learns the wave from the recording's own strong and isolated impacts: aligned below a sample, averaged, again; then
/// the noise and the jitter of its subbands. Absent where no three impacts sound alike.
std::optional<ImpactTemplate> estimate_template(const audio::AudioSource& sound, const audio::ArModel& noise,
                                                const std::vector<RoughImpact>& impacts);

/// Share of an impact's sound that the wave explains, as a correlation 0 ... 1.
/// @param total  sum of squares of the window
double correlation(const DelayEstimate& reading, double total);

}  // namespace bouncelab::detection
