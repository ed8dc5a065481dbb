// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "candidates/candidates.hpp"
#include "delay/impact_timer.hpp"
#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// A track while it is being timed.
struct TimedTrack {
  ImpactTimer timer;  ///< with the impacts known so far
  std::vector<TimedImpact> impacts;
};

/// Adds an impact to the track; its ringing is subtracted from then on.
void append(TimedTrack& track, const TimedImpact& impact);

/// An impact to come.
struct PredictedImpact {
  double t_s = 0.0;
  double flight_s = 0.0;  ///< before it
};

/// The next impact, by the eps of the last ones: the median of what the last impact, the one before it and the one
/// before that predict, each with the flight that ends there: one of them may be in a wrong place. Needs two impacts,
/// in time order.
PredictedImpact predict_next(const std::vector<TimedImpact>& track);

/// Searches for the impacts between the last one and the next candidate.
void fill_gap(TimedTrack& track, std::int64_t next_impact, double next_s);

/// Continues the track beyond its last impact, which may be a single loss or gain.
/// @param end_s  impacts are searched for up to it
void extend(TimedTrack& track, double end_s);

/// Times the impacts of one track with the template, in this order:
///
/// 1. each candidate, in time order, the ringing of the impacts before it subtracted; where impacts are missing between
///    two candidates they are searched for at the times that a geometric series of intervals predicts (fill_gap);
/// 2. the track is continued beyond its last impact as long as the sound supports the next one (extend);
/// 3. of the places where each impact may have been the most probable is chosen (delay_posterior.hpp); the others'
///    probabilities add to its variance.
///
/// @param end_s  the next track, or the end of the recording: impacts are searched for up to it [s]
std::vector<TimedImpact> time_track(WhiteSound& white, const ImpactTemplate& learned, const Track& track,
                                    const std::vector<Candidate>& candidates, double end_s);

}  // namespace bouncelab::detection
