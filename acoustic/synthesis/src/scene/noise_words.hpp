// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

namespace bouncelab::synthesis {

/// Successive blocks of four uniform 32-bit words of Philox4x32-10: key = seed; counter = (block, lower and upper
/// half), source, RandomStream::noise. So many at once that no round waits for the one before. Source: Salmon, Moraes,
/// Dror, Shaw, SC'11, doi:10.1145/2063384.2063405.
struct NoiseWords {
  static constexpr std::size_t kBlocks = 64;
  static constexpr std::size_t kFrames = 4 * kBlocks;  ///< a word for each
  std::uint32_t word[4][kBlocks];                      ///< of block first_block + k at [...][k]

  void draw(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block);
};

}  // namespace bouncelab::synthesis
