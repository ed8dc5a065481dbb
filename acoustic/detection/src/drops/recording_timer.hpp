// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "drops/drop_timer.hpp"

namespace bouncelab::detection {

struct TimedRecording {
  Onsets onsets;
  std::optional<LearnedWave> wave;  ///< of the longest track
  bool is_full_band = true;  ///< timed in the sound as recorded, though the impacts may have been found in a band
  std::optional<double> contact_time_at_1_mps_s;
  std::optional<double> contact_time_sigma_s;
};

/// Times all tracks. Each of a dozen impacts or more has a template of its own, since each drop strikes the plate at
/// another place; shorter ones share that of the recording. What was found in a low band is timed in the whole sound
/// where that halves the errors. The contact-time law is pooled over all drops: one ball.
/// What other bands show of the same drops is added (other_bands.hpp).
/// @param band         the one that was selected
/// @param other_bands  of the same sound, with tracks of their own
/// @param n_threads    that time tracks; the bands' sounds may be read by so many
/// @param name         goes into the column `recording`
TimedRecording time_recording(const BandOfDrops& band, const std::vector<BandOfDrops>& other_bands, double gravity_mps2,
                              int n_threads, const std::string& name);

}  // namespace bouncelab::detection
