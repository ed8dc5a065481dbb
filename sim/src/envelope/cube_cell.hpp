// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

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

/// A vector in the frame of a face: x along the face's outward normal, y and z along a and b. Keeps products of
/// vectors.
inline Vector3 to_face(int face, Vector3 v) {
  const double s = (face & 1) != 0 ? -1.0 : 1.0;
  if (face / 2 == 0) return {s * v.x, v.y, v.z};
  if (face / 2 == 1) return {s * v.y, v.z, v.x};
  return {s * v.z, v.x, v.y};
}
inline Vector3 from_face(int face, Vector3 v) {
  const double s = (face & 1) != 0 ? -1.0 : 1.0;
  if (face / 2 == 0) return {s * v.x, v.y, v.z};
  if (face / 2 == 1) return {v.z, s * v.x, v.y};
  return {v.y, v.z, s * v.x};
}

/// A square of a face: centre (a, b), half an edge h.
struct CubeCell {
  int face = 0;
  double a = 0.0, b = 0.0, h = 1.0;
};

/// The squares of a face that is divided into n_side by n_side.
inline CubeCell cell_of_square(int face, int ia, int ib, int n_side) {
  const double h = 1.0 / n_side;
  return {face, (2 * ia + 1) * h - 1.0, (2 * ib + 1) * h - 1.0, h};
}
/// Number of the square, along one edge, that a coordinate is in.
inline int square_of(double coordinate, int n_side) {
  return std::clamp(static_cast<int>((coordinate + 1.0) * 0.5 * n_side), 0, n_side - 1);
}

/// Child 0 ... 3 of a cell: bit 0 is the upper half in a, bit 1 in b.
inline CubeCell child_of(const CubeCell& cell, int child) {
  const double h = 0.5 * cell.h;
  return {cell.face, cell.a + ((child & 1) != 0 ? h : -h), cell.b + ((child & 2) != 0 ? h : -h), h};
}

/// A cell answers for directions in a region wider than itself by this factor, so that a direction on the move stays a
/// while before the next cell must be looked up. Regions of children lie in those of their parents.
inline constexpr double kRegionMargin = 1.15;

/// How far a direction at (a, b) of the face may turn and stay in the region of the cell [rad]. The inverse of the
/// gnomonic map stretches by at most 1 + a^2 + b^2.
inline double margin_in_region(const CubeCell& cell, double a, double b) {
  const double h = kRegionMargin * cell.h;
  const double a_most = std::abs(cell.a) + h, b_most = std::abs(cell.b) + h;
  return (h - std::max(std::abs(a - cell.a), std::abs(b - cell.b))) / (1.0 + a_most * a_most + b_most * b_most);
}

/// The region of a cell in the frame of its face: directions X/|X|, X = (1, a +- h, b +- h).
class Region {
 public:
  explicit Region(const CubeCell& cell)
      : a_(cell.a),
        b_(cell.b),
        h_(kRegionMargin * cell.h),
        edges_{edge(a_ + h_), edge(-(a_ - h_)), edge(b_ + h_), edge(-(b_ - h_))} {
    const double a_least = std::max(0.0, std::abs(a_) - h_), b_least = std::max(0.0, std::abs(b_) - h_);
    const double a_most = std::abs(a_) + h_, b_most = std::abs(b_) + h_;
    shortest_ = std::sqrt(1.0 + a_least * a_least + b_least * b_least);
    longest_ = std::sqrt(1.0 + a_most * a_most + b_most * b_most);
  }

  /// Lower bound of |n - u| over the region: u's height above the planes through the centre and the region's edges.
  double distance_at_least(Vector3 u) const {
    const double a =
        larger(edges_[0].along * u.y - edges_[0].normal * u.x, -edges_[1].along * u.y - edges_[1].normal * u.x);
    const double b =
        larger(edges_[2].along * u.z - edges_[2].normal * u.x, -edges_[3].along * u.z - edges_[3].normal * u.x);
    return larger(larger(a, b), 0.0);
  }

  /// X0 = (1, a0, b0) at the middle, the greatest deviation from a0 and b0, and bounds of |X|.
  Vector3 centre() const { return {1.0, a_, b_}; }
  double half() const { return h_; }
  double shortest() const { return shortest_; }
  double longest() const { return longest_; }

 private:
  /// By value: loops over std::max are not vectorised.
  static double larger(double a, double b) { return a > b ? a : b; }
  /// The plane through the ball's centre and an edge at coordinate x (or -x): (x_u - x u.x) / sqrt(1 + x^2).
  struct Edge {
    double along, normal;
  };
  static Edge edge(double x) {
    const double s = 1.0 / std::sqrt(1.0 + x * x);
    return {s, s * x};
  }

  double a_, b_, h_;
  std::array<Edge, 4> edges_;
  double shortest_ = 1.0, longest_ = 1.0;  ///< bounds of |X|
};

/// A node on the way down to a leaf.
struct Way {
  Envelope::Node node;
  CubeCell cell;

  int child_around(const CubePoint& point) const { return (point.a >= cell.a ? 1 : 0) + (point.b >= cell.b ? 2 : 0); }
  /// Of an inner node: the child around the point.
  const Envelope::Node& next(const Envelope::Patch& patch, const CubePoint& point) const {
    return patch.nodes[node.first + static_cast<std::uint32_t>(child_around(point))];
  }
  void descend(const Envelope::Patch& patch, const CubePoint& point) {
    node = next(patch, point);
    cell = child_of(cell, child_around(point));
  }
  Envelope::Cell found(const CubePoint& point) const {
    return {margin_in_region(cell, point.a, point.b), static_cast<double>(node.max_elevation)};
  }
};

/// The search for the leaf around a direction, one access to memory after the other. Each step ends by asking the
/// processor for what the next reads, so that searches of several directions can take turns and none waits.
class LeafSearch {
 public:
  /// @param envelope  must outlive the search and the leaf
  /// @param n         unit vector of the body frame
  LeafSearch(const Envelope& envelope, Vector3 n);

  /// One step. @return the leaf once it is found; its sites are asked for then
  std::optional<Envelope::Leaf> advance();

 private:
  enum class Next { start, node, list };

  const Envelope* envelope_;
  CubePoint point_;
  int ia_, ib_;  ///< the square around the direction
  const Envelope::Start* start_;
  const Envelope::Patch* patch_;
  Next next_ = Next::start;
  Way way_;
  const std::uint16_t* list_ = nullptr;
};

}  // namespace bouncelab::sim
