// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "tracking/observations.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// A track's own sounds, with what it explains not counted among their neighbours.
struct OwnSounds {
  std::vector<std::size_t> candidates;  ///< indices, rising
  std::vector<std::size_t> explained;   ///< these and their echoes, rising
  std::vector<Observation> seen;        ///< of each
  std::vector<double> same_source;      ///< weight of one source of each and the next
};

OwnSounds own_sounds(const Observations& observations, const Track& track);

/// The tracks once more, now that the balls are known: which observation each begins with, and its log odds with its
/// own sounds and their echoes not counted as clutter. What a surer track has claimed since is no other's.
/// @param tracks  one after the other in time
std::vector<Track> rescored(const Observations& observations, std::vector<Track> tracks);

/// Weighs tracks by how often balls are dropped in their recording, which is not known: the rate lies between about one
/// drop in the whole recording and TrackingModel::start_log_odds, every order of magnitude as probable as another
/// (Jeffreys 1946, doi:10.1098/rspa.1946.0056), and the other tracks tell. So a random row of sounds in an hour of
/// music needs better reasons than three knocks in a clip of three seconds, and many drops speak for each other.
/// @param candidates  of the recording; time without them offers no chance
/// @param tracks      with log odds for the largest rate; they are lowered
void weigh_by_drop_rate(const std::vector<Candidate>& candidates, std::vector<Track>& tracks);

}  // namespace bouncelab::detection
