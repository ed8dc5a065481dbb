// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "bouncelab/sim/envelope.hpp"
#include "envelope/arena.hpp"
#include "envelope/cube_cell.hpp"
#include "envelope/dominance.hpp"
#include "envelope/floor_map.hpp"

namespace bouncelab::sim {

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

}  // namespace bouncelab::sim
