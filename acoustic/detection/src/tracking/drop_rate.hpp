// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "candidates/candidates.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// Weighs tracks by how often balls are dropped in their recording, which is not known: the rate lies between about one
/// drop in the whole recording and TrackingModel::start_log_odds, every order of magnitude as probable as another
/// (Jeffreys 1946, doi:10.1098/rspa.1946.0056), and the other tracks tell. So a random row of sounds in an hour of
/// music needs better reasons than three knocks in a clip of three seconds, and many drops speak for each other.
/// @param candidates  of the recording; time without them offers no chance
/// @param tracks      with log odds for the largest rate; they are lowered
void weigh_by_drop_rate(const std::vector<Candidate>& candidates, std::vector<Track>& tracks);

}  // namespace bouncelab::detection
