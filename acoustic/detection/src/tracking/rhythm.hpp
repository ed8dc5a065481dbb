// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tracking/densities.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// What the same sounds are as a rhythm: steps, claps, syllables, strokes, a metronome. The log interval follows a
/// local level with a trend (Harvey 1989, doi:10.1017/CBO9781107049994), about which it scatters as the rhythm itself
/// shows. A beat may be left out, as impacts are, or divided by two. Loudness scatters about its running mean, whatever
/// the interval.
class Rhythm {
 public:
  /// @param log_interval   of the first two sounds [ln s]
  /// @param log_amplitude  their mean
  Rhythm(double log_interval, double log_amplitude);
  Rhythm() = default;

  /// Density of the next sound [1/s, per unit of log amplitude]; then takes it into the rhythm.
  /// @param sigma_s  of the two times [s]
  double follow(double interval_s, double log_amplitude, double sigma_s, const TrackingModel& model);

 private:
  double level_ = 0.0;  ///< of the log interval
  double trend_ = 0.0;
  double sum_squares_ = 0.0;
  int n_sounds_ = 2;
  Loudness loudness_;
};

}  // namespace bouncelab::detection
