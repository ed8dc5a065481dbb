// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/surface.hpp"
#include "envelope/arena.hpp"
#include "envelope/cube_cell.hpp"
#include "envelope/dominance.hpp"
#include "envelope/floor_map.hpp"

namespace bouncelab::sim {

/// Patches are ordered by face, then ib, then ia; the index of face 6 is their number.
inline std::size_t patch_index(int face, int ia, int ib, int n_side) {
  const auto n = static_cast<std::size_t>(n_side);
  return (static_cast<std::size_t>(face) * n + static_cast<std::size_t>(ib)) * n + static_cast<std::size_t>(ia);
}

/// The asperities of each patch, one patch after the other.
struct Distribution {
  std::vector<std::size_t> begin;  ///< of each patch's part of `asperities`, and the end
  std::vector<std::uint32_t> asperities;

  std::span<const std::uint32_t> of(std::size_t patch) const {
    return std::span(asperities).subspan(begin[patch], begin[patch + 1] - begin[patch]);
  }
};

/// Finds for each patch the asperities that rise in its region above the envelope's least elevation (and a few more);
/// in their order.
/// @param n_side  patches along an edge of the cube
Distribution distribute(const Ball& ball, const Surface& surface, int n_side, double least_elevation);

inline constexpr std::uint32_t kNoList = 0xffffffffU;
/// Has four children, and no list.
inline bool is_inner(const Envelope::Node& node) { return node.n_list == kNoList; }

/// Grows the quadtrees of patches, one after the other; what it works with is kept from one to the next.
class PatchBuilder {
 public:
  explicit PatchBuilder(const FloorMap& floors) : floors_(floors) {}

  /// What may touch in the patch, to be filled in before build(); `site` is the index into the surface.
  Contenders& contenders() { return levels_.front(); }

  /// @param cell   the whole patch
  /// @param arena  gets the nodes, sites and asperities; the patch has no lists yet
  Envelope::Patch build(const CubeCell& cell, Arena& arena);
  /// The lists of all leaves of the patch built last.
  const std::vector<std::uint16_t>& lists() const { return lists_; }

 private:
  void grow(std::size_t node, const CubeCell& cell, std::size_t depth);
  void make_leaf(Envelope::Node& node, int face, const Contenders& list);
  std::uint32_t add_site(int face, const Contenders& list, std::size_t i);

  const FloorMap& floors_;
  std::deque<Contenders> levels_{1};  ///< [0]: those of the patch; [1 + depth]: of the cell that is being worked on
  ContenderScratch scratch_;
  std::vector<std::uint32_t> given_;   ///< asperities by number within the patch
  std::vector<std::uint32_t> place_;   ///< in the patch's sites, by number within the patch
  std::vector<std::uint32_t> placed_;  ///< of one leaf
  std::vector<Envelope::Node> nodes_;
  std::vector<Envelope::Site> sites_;
  std::vector<std::uint32_t> asperities_;  ///< of the sites
  std::vector<std::uint16_t> lists_;
};

/// The squares at which a search may start: equal, n_side to a face's edge, ordered by face, then ib, then ia.
struct StartGrid {
  int depth = 0;   ///< below the patches
  int n_side = 1;  ///< patches' n_side 2^depth

  std::size_t index(int face, int ia, int ib) const {
    const auto n = static_cast<std::size_t>(n_side);
    return (static_cast<std::size_t>(face) * n + static_cast<std::size_t>(ib)) * n + static_cast<std::size_t>(ia);
  }
};

/// Squares enough that there are two thirds as many as leaves, or half as many where they take a gigabyte: most leaves
/// then fill a square or more.
StartGrid start_grid_for(const std::vector<Envelope::Patch>& patches, int n_side);

/// Fills in the starts of the squares of patch (ia, ib). @return the lists that they do not hold, to which the nodes
/// refer from now on
/// @param lists  of all leaves, to which the nodes refer
std::vector<std::uint16_t> write_starts(const StartGrid& grid, int face, int ia, int ib,
                                        std::span<const std::uint16_t> lists, std::span<Envelope::Node> nodes,
                                        std::span<Envelope::Start> starts);

}  // namespace bouncelab::sim
