// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/random.hpp"

#include <Random123/philox.h>

#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab {

std::array<std::uint64_t, 4> philox_block(std::uint64_t seed, RandomStream stream, std::uint64_t index,
                                          std::uint64_t draw) {
  const r123::Philox4x64::ctr_type counter{{index, draw, 0, 0}};
  const r123::Philox4x64::key_type key{{seed, static_cast<std::uint64_t>(stream)}};
  const auto words = r123::Philox4x64{}(counter, key);
  return {words[0], words[1], words[2], words[3]};
}

std::uint64_t Random::bits() {
  if (n_left_ == 0) {
    block_ = philox_block(seed_, stream_, index_, draw_++);
    n_left_ = 4;
  }
  return block_[static_cast<std::size_t>(4 - n_left_--)];
}

double Random::uniform() {
  // the upper 53 bits, in the middle of their cell: neither 0 nor 1 can occur, so log() is safe
  return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53;
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2.0 * log(uniform()));
  const SinCos angle = sin_cos(2.0 * std::numbers::pi * uniform());
  spare_normal_ = radius * angle.sin;
  has_spare_ = true;
  return radius * angle.cos;
}

double Random::exponential() { return -log(uniform()); }

}  // namespace bouncelab
