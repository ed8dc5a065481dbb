// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "candidates/candidates.hpp"
#include "delay/track_search.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// Searches for the impacts between the last one and the next candidate.
void fill_gap(TimedTrack& track, std::int64_t next_impact, double next_s);

/// Continues the track beyond its last impact.
/// @param end_s  impacts are searched for up to it
void extend(TimedTrack& track, double end_s);

}  // namespace bouncelab::detection
