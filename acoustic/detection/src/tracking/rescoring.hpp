// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "tracking/observations.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// The tracks once more, now that the balls are known: which observation each begins with, and its log odds with its
/// own sounds and their echoes not counted as clutter. What a surer track has claimed since is no other's.
/// @param tracks  one after the other in time, and so are those returned
std::vector<Track> rescored(const Observations& observations, std::vector<Track> tracks);

/// Of each impact, given that its track is a ball's (impact_odds.hpp).
void set_impact_probabilities(const Observations& observations, std::vector<Track>& tracks);

}  // namespace bouncelab::detection
