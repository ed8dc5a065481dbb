// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bouncelab/core/parallel.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

class Arena;
class LeafSearch;

/// The upper envelope of the asperities, indexed for constant-time search whatever the radii.
///
/// With n the body-fixed direction that points at the plate, the ball reaches R (1 + E(n)) below its centre,
///
///   E(n) = max(0, max_j e_j(n)),   e_j(n) = R_j/R - |n - u_j|^2 / 2   (|n| = |u_j| = 1),
///
/// a power diagram restricted to the sphere. Each face of the cube around the sphere carries a quadtree in gnomonic
/// coordinates. A cell answers for a region, itself and a margin; it lists every asperity that can be the highest
/// anywhere in its region (a superset; none is missed), because e_k - e_j is linear in n, so that where k beats j in
/// the whole region follows from its corners. Cells are split until the list is short: one large asperity lengthens no
/// list but those of the cells in which it can touch. Source: Aurenhammer, SIAM J. Comput. 16, 78 (1987),
/// doi:10.1137/0216006 (power diagrams).
class Envelope {
 public:
  /// An asperity that can touch; never in two lines of the cache, because a search loads ten of them from memory.
  struct alignas(32) Site {
    Vector3 direction;
    double height = 0.0;  ///< R_j / R
  };

  /// Where a direction n lies: a cell and what E(n) reaches in its region.
  struct Cell {
    double margin_rad = 0.0;     ///< n may turn by this and stay in the region
    double max_elevation = 0.0;  ///< E(n) <= max_elevation in the region
  };
  /// The smallest cell, and what can touch in its region.
  struct Leaf : Cell {
    std::span<const std::uint16_t> list;        ///< what can be highest somewhere in the region, as indices ...
    std::span<const Site> sites;                ///< ... into these
    std::span<const std::uint32_t> asperities;  ///< of the sites, indices into the surface
  };

  /// @param surface    directions of unit length, radii in (0, R)
  /// @param n_threads  0: all cores; the result does not depend on it
  /// @param progress   called with patches done; may throw to stop
  Envelope(const Ball& ball, const Surface& surface, int n_threads = 1, const ProgressCallback& progress = {});

  /// max E(n) over all directions.
  double max_elevation() const { return max_elevation_; }

  /// E(n) and the asperity that makes it (-1: the smooth sphere).
  struct Support {
    double elevation = 0.0;
    std::int64_t asperity = -1;
  };
  /// @param n  unit vector of the body frame
  Support support(Vector3 n) const;

  /// The leaf around n.
  Leaf leaf_at(Vector3 n) const;
  /// The largest cell around n whose region lies below `elevation`; where there is none, the leaf.
  Cell cell_below(double elevation, Vector3 n) const;

  struct Node {
    float max_elevation = 0.0F;
    std::uint32_t first = 0;   ///< first of four children, or first entry of the list
    std::uint32_t n_list = 0;  ///< 0xffffffff: has children
    std::uint32_t base = 0;    ///< the site that 0 in the list means
  };
  /// Where the search for a leaf starts; as large as a line of the cache, so that most often one access to memory leads
  /// to the list.
  struct alignas(64) Start {
    static constexpr std::size_t kMostListed = 22;
    Node node;
    std::uint32_t depth = 0;                        ///< of the node
    std::array<std::uint16_t, kMostListed> list{};  ///< of a leaf, where it fits
  };
  /// A square of one of the cube's faces with its quadtree; node 0 is the root.
  struct Patch {
    std::span<Node> nodes;
    std::span<const std::uint16_t> lists;  ///< of the leaves that the starts do not hold
    std::span<const Site> sites;
    std::span<const std::uint32_t> asperities;  ///< of the sites
  };

 private:
  friend LeafSearch;

  int n_side_ = 1;       ///< patches along an edge of the cube
  int start_depth_ = 0;  ///< each patch has 2^start_depth squared starts
  double max_elevation_ = 0.0;
  std::vector<Patch> patches_;
  std::span<Start> starts_;       ///< of equal squares: the leaf around each, or the node that is the square
  std::shared_ptr<Arena> arena_;  ///< has what the patches and starts point to; shared by copies, which never change
};

}  // namespace bouncelab::sim
