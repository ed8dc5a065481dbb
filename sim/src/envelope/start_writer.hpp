// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/sim/envelope.hpp"

namespace bouncelab::sim {

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
