// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/clipping.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bouncelab::detection {

float clip_level(const audio::AudioSource& sound, double t_s) {
  constexpr double kAround_s = 5e-3;
  const auto n = static_cast<std::size_t>(kAround_s * sound.rate_hz) + 3;
  const std::int64_t first = std::llround(t_s * sound.rate_hz) - 1;
  std::vector<float> x(n);
  audio::read_padded(sound, first, x);
  int n_flat = 0;  // 0 for most impacts, and this loop is vectorised
  for (std::size_t k = 2; k < x.size(); ++k)
    n_flat += static_cast<int>(x[k] == x[k - 1]) & static_cast<int>(x[k] == x[k - 2]) & static_cast<int>(x[k] != 0.0F);
  if (n_flat == 0) return INFINITY;
  float largest = 0.0F;
  for (const float value : x) largest = std::max(largest, std::abs(value));
  for (std::size_t k = 2; k < x.size(); ++k)
    if (std::abs(x[k]) == largest && largest > 0.0F && x[k - 1] == x[k] && x[k - 2] == x[k]) return largest;
  return INFINITY;
}

}  // namespace bouncelab::detection
