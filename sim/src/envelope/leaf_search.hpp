// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>

#include "bouncelab/sim/envelope.hpp"
#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {

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
