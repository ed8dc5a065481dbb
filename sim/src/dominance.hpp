// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/sim/envelope.hpp"
#include "cube_cell.hpp"

namespace bouncelab {

/// Bounds of e(n) = height - |n - u|^2/2 over a cap, by the triangle inequality of chords.
inline double elevation_at_most(const Envelope::Site& site, const Cap& cap) {
  const double nearest = std::max(0.0, norm(site.direction - cap.centre) - cap.radius);
  return site.height - 0.5 * nearest * nearest;
}
inline double elevation_at_least(const Envelope::Site& site, const Cap& cap) {
  const double farthest = norm(site.direction - cap.centre) + cap.radius;
  return site.height - 0.5 * farthest * farthest;
}

/// Those of `candidates` (indices into sites) that can be the highest somewhere in the cap: a superset, made by
/// dropping what lies below the guaranteed elevation of the envelope, or below one of five rivals everywhere in the
/// cap. Keeps the order of the candidates. Of equal sites the first stays.
void keep_what_can_be_highest(std::span<const Envelope::Site> sites, const std::vector<std::uint32_t>& candidates,
                              const Cap& cap, std::vector<std::uint32_t>& kept);

/// The same with every one as a rival of every other: for short lists.
void drop_dominated_pairs(std::span<const Envelope::Site> sites, const Cap& cap, std::vector<std::uint32_t>& list);

}  // namespace bouncelab
