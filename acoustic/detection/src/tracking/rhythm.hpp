// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "tracking/densities.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

constexpr std::size_t kRhythmKinds = 2;  // by hand, by a machine

/// What the same sounds are as a rhythm: steps, claps, syllables, strokes, a metronome.
///
/// By hand, the log interval follows a local level with a trend (Harvey 1989, doi:10.1017/CBO9781107049994). By a
/// machine, beats stand in an even row and the sounds scatter about them: an alpha-beta filter of beat and interval,
/// with the gains of a growing, then exponentially forgotten line (Kalata 1984, doi:10.1109/TAES.1984.310438). A beat
/// may be left out, as impacts are, or divided by two. Loudness scatters about its running mean, whatever the interval.
class Rhythm {
 public:
  /// @param log_interval   of the first two sounds [ln s]
  /// @param log_amplitude  their mean
  Rhythm(double log_interval, double log_amplitude);

  /// Densities of the next sound [1/s, per unit of log amplitude], by kind; then takes it into the rhythm.
  /// @param sigma_s  of the two times [s]
  std::array<double, kRhythmKinds> follow(double interval_s, double log_amplitude, double sigma_s);

 private:
  double follow_by_hand(double interval_s, double sigma_s);
  double follow_by_machine(double interval_s, double sigma_s);

  double level_;  ///< of the log interval, by hand
  double trend_ = 0.0;
  double sum_squares_ = 0.0;
  double period_s_;                       ///< by machine
  double late_s_ = 0.0;                   ///< by which the last sound came after its beat
  double sum_squares_of_lateness_ = 0.0;  ///< in intervals
  int n_sounds_ = 2;
  Loudness loudness_;
};

}  // namespace bouncelab::detection
