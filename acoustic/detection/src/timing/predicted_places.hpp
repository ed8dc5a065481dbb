// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/timed_impact.hpp"
#include "timing/track_search.hpp"

namespace bouncelab::detection {

/// Adds, to each impact that is not where the intervals around it expect it, the places that the sound has where it is
/// expected: its candidate may be another sound, or it was searched for beside a neighbour that was in the wrong place.
/// The sound then decides between all of them. In turns, since what is expected follows from the neighbours.
/// @param track  in time order
void add_predicted_places(const Search& search, std::vector<TimedImpact>& track);

}  // namespace bouncelab::detection
