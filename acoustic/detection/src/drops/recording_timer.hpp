// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "drops/drop_timer.hpp"

namespace bouncelab::detection {

/// Adds to a drop the impacts that only another band of the same sound shows: one band may hide in echoes, in clutter
/// or in a codec's noise what another shows, above all at the end of a drop, and which of them was selected says
/// nothing of the ball.
///
/// The two are the same drop where they share five impacts and half of those of the shorter one. Impacts of the other
/// band whose numbers the drop lacks are added, with times moved by the median difference of the nine nearest shared
/// impacts, whose error enters `sigma_s`; where the two bands number the shared impacts on either side differently,
/// none is. What the other band has by prediction alone is added only where its template explains half of the impacts'
/// energy and that of the drop does not, which else would have shown it. Sets no speeds.
/// @param begin_s, end_s  the last impact of the drop before and the first of the next one: none is added beyond
/// @return how many were added
std::size_t add_impacts_of_other_band(const TimedDrop& other, double begin_s, double end_s, TimedDrop& drop);

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
