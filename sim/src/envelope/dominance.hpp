// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/sim/envelope.hpp"
#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {

/// Upper bound of e(n) = height - |n - u|^2/2 over the region; the site's direction in the frame of the face.
inline double elevation_at_most(const Envelope::Site& site, const Region& region) {
  const double distance = region.distance_at_least(site.direction);
  return site.height - 0.5 * distance * distance;
}

/// Reduces the list of a wider region to a region within: a superset of the sites that are the highest somewhere in
/// it. In turn goes what stays below the floor; what one of five competitors beats everywhere in the region; in short
/// lists what any other beats. The order stays; of equal sites the first stays.
/// @param floor  the envelope is nowhere in the region lower than this
/// @param sites  with directions in the frame of the region's face
/// @param wider  indices into the sites
std::vector<std::uint32_t> contenders_within(const Region& region, double floor, std::span<const Envelope::Site> sites,
                                             const std::vector<std::uint32_t>& wider);

}  // namespace bouncelab::sim
