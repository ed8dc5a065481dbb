// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "candidates/candidates.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// Moves the impacts of a track to where their sound begins.
///
/// The sound of a soft ball in a room rises in steps, each a candidate: the floor's first motion, the ball's shell,
/// the wall. Steps follow each other alike at every impact, other sounds do not: where at least half of a track's
/// impacts have a candidate the same time before or after them, those that have it before them begin there.
void begin_at_first_arrivals(const std::vector<Candidate>& candidates, std::vector<Track>& tracks);

}  // namespace bouncelab::detection
