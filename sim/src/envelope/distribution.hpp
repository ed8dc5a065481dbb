// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/sim/surface.hpp"

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

}  // namespace bouncelab::sim
