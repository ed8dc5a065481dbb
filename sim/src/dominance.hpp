// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/sim/envelope.hpp"
#include "cube_cell.hpp"

namespace bouncelab {

/// Upper bound of e(n) = height - |n - u|^2/2 over the region; the site's direction in the frame of the face.
inline double elevation_at_most(const Envelope::Site& site, const Region& region) {
  const double distance = region.distance_at_least(site.direction);
  return site.height - 0.5 * distance * distance;
}

/// What can be the highest somewhere in a region.
struct Contenders {
  std::vector<std::uint32_t> list;  ///< indices into the sites
  double floor = 0.0;               ///< the envelope is nowhere in the region lower than this
};

/// Reduces the contenders of a wider region to those of a region within: a superset of those that are the highest
/// somewhere in it. In turn goes what lies below the elevation that the envelope is sure to have everywhere in the
/// region; what one of five rivals beats everywhere in it; in short lists what any other beats. The order stays; of
/// equal sites the first stays.
/// @param sites  with directions in the frame of the region's face
Contenders contenders_within(const Region& region, std::span<const Envelope::Site> sites, const Contenders& wider);

}  // namespace bouncelab
