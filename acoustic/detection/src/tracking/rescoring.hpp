// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "tracking/observations.hpp"
#include "tracking/own_sounds.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// Tracks, one after the other in time, and the own sounds of each.
struct Rescored {
  std::vector<Track> tracks;
  std::vector<OwnSounds> own;
};

/// The tracks once more, now that the balls are known: which observation each begins with, and its log odds with its
/// own sounds and their echoes not counted as clutter. What a surer track has claimed since is no other's.
/// @param tracks  one after the other in time
Rescored rescored(const Observations& observations, std::vector<Track> tracks);

}  // namespace bouncelab::detection
