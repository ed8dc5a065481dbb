// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "candidates/candidates.hpp"
#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

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
