// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/not_finite.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::audio {
namespace {

/// By the bits: the exponent of what is not finite is all ones.
BOUNCELAB_VECTOR_CLONES bool all_finite(const float* samples, std::size_t n) {
  constexpr std::uint32_t kAllOnes = 0x7f800000;
  std::uint32_t n_bad = 0;
  for (std::size_t k = 0; k < n; ++k) n_bad += (std::bit_cast<std::uint32_t>(samples[k]) & kAllOnes) == kAllOnes;
  return n_bad == 0;
}

}  // namespace

std::size_t first_not_finite(std::span<const float> samples) {
  constexpr std::size_t kBlock = 4096;  // samples looked at without a branch each
  for (std::size_t begin = 0; begin < samples.size(); begin += kBlock) {
    const std::span<const float> block = samples.subspan(begin, std::min(kBlock, samples.size() - begin));
    if (all_finite(block.data(), block.size())) continue;
    const auto bad = std::find_if(block.begin(), block.end(), [](float x) { return !std::isfinite(x); });
    return begin + static_cast<std::size_t>(bad - block.begin());
  }
  return samples.size();
}

}  // namespace bouncelab::audio
