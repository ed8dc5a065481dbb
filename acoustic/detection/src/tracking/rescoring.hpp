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

/// A track's own sounds and their echoes: chance need not offer them.
/// @param own  two candidates or more, rising
/// @return indices, rising
std::vector<std::size_t> explained_by(const Observations& observations, const std::vector<std::size_t>& own);

/// The tracks once more, now that the balls are known: which observation each begins with, and its log odds with its
/// own sounds and their echoes not counted as clutter. What a surer track has claimed since is no other's.
/// @param tracks  one after the other in time
std::vector<Track> rescored(const Observations& observations, std::vector<Track> tracks);

}  // namespace bouncelab::detection
