// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "timing/timed_impact.hpp"

namespace bouncelab::detection {

/// The better of two fits of one impact, with the places of both as hypotheses: each place once, the most likely first.
/// @param same_s  places nearer than this are one
ImpactFit merged(const ImpactFit& a, const ImpactFit& b, double same_s);

/// The fit with its three most likely alternatives only.
ImpactFit with_fewer_places(ImpactFit fit);

}  // namespace bouncelab::detection
