// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {

/// Asperities that may be the highest somewhere in a region, in the frame of its face; by columns, because most of the
/// time of building an envelope goes on loops over them.
struct Contenders {
  std::vector<double> x, y, z;  ///< directions
  std::vector<double> height;   ///< R_j / R
  std::vector<std::uint32_t> site;

  std::size_t size() const { return site.size(); }
  void resize(std::size_t n) {
    for (std::vector<double>* column : {&x, &y, &z, &height}) column->resize(n);
    site.resize(n);
  }
  /// Contender i of another list becomes number n of this.
  void set(std::size_t n, const Contenders& from, std::size_t i) {
    x[n] = from.x[i];
    y[n] = from.y[i];
    z[n] = from.z[i];
    height[n] = from.height[i];
    site[n] = from.site[i];
  }
};

/// Columns that are worked out anew for each region.
struct ContenderScratch {
  std::vector<double> elevation;  ///< upper bounds of e(n) in the region
  std::vector<double> centre;     ///< u.X0
  std::vector<double> lead;
  std::vector<std::uint8_t> is_beaten;
};

/// Upper bounds of e(n) = height - |n - u|^2/2 over the region.
void elevations_at_most(const Region& region, const Contenders& list, std::vector<double>& elevation);

/// Reduces the list of a wider region to a region within: a superset of the contenders that are the highest somewhere
/// in it. In turn goes what stays below the floor; what one of five competitors beats everywhere in the region; in
/// short lists what any other beats. The order stays; of equal contenders the first stays.
/// @param floor   the envelope is nowhere in the region lower than this
/// @param within  result; not the same object as `wider`
void find_contenders_within(const Region& region, double floor, const Contenders& wider, Contenders& within,
                            ContenderScratch& scratch);

}  // namespace bouncelab::sim
