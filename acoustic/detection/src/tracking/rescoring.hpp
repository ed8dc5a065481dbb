// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "tracking/observations.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// Looks at each train once more, now that the ball is known: which sound it begins with, and whether its odds hold
/// when its own sounds are no longer each other's rivals and sounds like its own that are not of it speak against it.
/// Those that do not hold are taken out.
/// @param trains  one after the other in time
void review_trains(const HeardSounds& sounds, std::vector<Train>& trains);

}  // namespace bouncelab::detection
