// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "bouncelab/sim/vector3.hpp"

namespace bouncelab {

/// Gnomonic coordinates of a direction: the face of the cube [-1, 1]^3 it leaves through, and where.
struct CubePoint {
  int face = 0;  ///< 2 axis + (1 where the component is negative)
  double a = 0.0, b = 0.0;
};

inline CubePoint cube_point(Vector3 n) {
  const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
  if (ax >= ay && ax >= az) return {n.x < 0.0 ? 1 : 0, n.y / ax, n.z / ax};
  if (ay >= az) return {n.y < 0.0 ? 3 : 2, n.z / ay, n.x / ay};
  return {n.z < 0.0 ? 5 : 4, n.x / az, n.y / az};
}

/// A square of a face: centre (a, b), half an edge h.
struct CubeCell {
  int face = 0;
  double a = 0.0, b = 0.0, h = 1.0;
};

/// The point of the cube's surface (not normalised).
inline Vector3 on_cube(int face, double a, double b) {
  const double s = (face & 1) != 0 ? -1.0 : 1.0;
  switch (face / 2) {
    case 0:
      return {s, a, b};
    case 1:
      return {b, s, a};
    default:
      return {a, b, s};
  }
}

/// The cap of directions that a cell answers for: |n - centre| <= radius.
struct Cap {
  Vector3 centre;
  double radius = 0.0;
};

/// How much wider than its cell a region is: directions on the move stay a while before the next cell must be looked
/// up.
inline constexpr double kRegionMargin = 1.15;

/// The gnomonic map stretches by at most 1/sqrt(1 + a^2 + b^2), so no point of the cell is farther from its centre than
/// sqrt(2) h times the largest stretch in the cell.
inline Cap region_of(const CubeCell& cell) {
  const double a_least = std::max(0.0, std::abs(cell.a) - cell.h), b_least = std::max(0.0, std::abs(cell.b) - cell.h);
  const double stretch = 1.0 / std::sqrt(1.0 + a_least * a_least + b_least * b_least);
  return {normalized(on_cube(cell.face, cell.a, cell.b)), kRegionMargin * std::sqrt(2.0) * cell.h * stretch};
}

/// Child 0 ... 3 of a cell: bit 0 is the upper half in a, bit 1 in b.
inline CubeCell child_of(const CubeCell& cell, int child) {
  const double h = 0.5 * cell.h;
  return {cell.face, cell.a + ((child & 1) != 0 ? h : -h), cell.b + ((child & 2) != 0 ? h : -h), h};
}

}  // namespace bouncelab
