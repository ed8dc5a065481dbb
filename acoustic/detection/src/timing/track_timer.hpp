// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "candidates/candidates.hpp"
#include "timing/impact_timer.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// One impact of a train, timed.
struct TimedTrackImpact {
  std::int64_t impact = 0;
  TimedImpact timed;
  double until_s = 0.0;   ///< from here on the sound belongs to the next impact
  bool inferred = false;  ///< found only because the train expected it
  bool overlap = false;   ///< its sound reaches into that of the next
  bool doubtful = false;  ///< may be a cycle off
  double doubt_s = 0.0;   ///< what that adds to the standard error, in quadrature
};

/// Times a train by the learned wave. Where an impact is missing it is searched for at the time that its neighbours
/// predict; the train is followed on beyond its last impact as long as the sound supports the next one; impacts at its
/// end that the wave does not support are given up.
/// @param begin_s, end_s  stretch of the recording that belongs to this train
std::vector<TimedTrackImpact> time_track(const audio::AudioSource& sound, const ImpactTemplate& wave,
                                         const Train& train, const std::vector<Candidate>& candidates, double end_s);

}  // namespace bouncelab::detection
