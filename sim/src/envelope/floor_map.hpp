// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/sim/surface.hpp"
#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {

/// Guaranteed elevation of the envelope, by small squares of the cube's faces: makes it cheap to decide that an
/// asperity cannot touch in a region, before it is held against any other.
///
/// The highest asperity of a square q' is nowhere in a square q seen lower than height - D^2/2, D the largest distance
/// |n - u| of n in q and u in q'. The floor of q is the best such bound of the squares within two of it, over the
/// squares of this and of every coarser map (each of twice the width), so that an asperity of any size is known as far
/// as it reaches.
class FloorMap {
 public:
  /// @param margin  of the gnomonic coordinates beyond the edges of a face, >= 0
  FloorMap(const Ball& ball, const Surface& surface, double margin);

  /// E(n) is nowhere in the region of the cell lower than this; >= 0.
  double elevation_at_least(const CubeCell& cell) const;
  /// ... nowhere at all.
  double least() const { return least_; }

 private:
  double half_width_;  ///< of the map of a face, in gnomonic coordinates
  int n_side_ = 1;     ///< squares along an edge, a power of two
  std::vector<float> floors_;
  double least_ = 0.0;
};

}  // namespace bouncelab::sim
