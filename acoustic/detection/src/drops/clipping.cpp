// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/clipping.hpp"

#include <algorithm>
#include <cstdint>
#include <map>

namespace bouncelab::detection {
namespace {

std::vector<float> samples_after(const audio::AudioSource& sound, double t_s) {
  constexpr double kAround_s = 5e-3;
  std::vector<float> x(static_cast<std::size_t>(kAround_s * sound.rate_hz) + 3);
  audio::read_padded(sound, std::llround(t_s * sound.rate_hz) - 1, x);
  return x;
}

}  // namespace

bool ClippingLimits::are_reached(const audio::AudioSource& sound, double t_s) const {
  if (std::isinf(lowest) && std::isinf(highest)) return false;
  const std::vector<float> x = samples_after(sound, t_s);
  return std::any_of(x.begin(), x.end(), [&](float value) { return value == lowest || value == highest; });
}

ClippingLimits find_clipping_limits(const audio::AudioSource& sound, const std::vector<double>& impacts_s) {
  constexpr float kFullScale = 0.99F;  // 127/128 and more
  std::map<float, int> n_impacts;      // by their largest and smallest values
  for (const double t_s : impacts_s) {
    const std::vector<float> x = samples_after(sound, t_s);
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    for (const float value : {*least, *most})
      if (std::abs(value) > kFullScale || std::search_n(x.begin(), x.end(), 2, value) != x.end()) ++n_impacts[value];
  }
  const auto is_reached_again = [&](float value) { return n_impacts.contains(value) && n_impacts.at(value) > 1; };
  if (n_impacts.empty()) return {};
  float lowest = n_impacts.begin()->first, highest = n_impacts.rbegin()->first;
  if (!is_reached_again(lowest) && !is_reached_again(highest)) return {};
  constexpr std::int64_t kAtOnce = 1 << 14;
  std::vector<float> x;
  for (std::int64_t first = 0; first < sound.n_samples; first += kAtOnce) {
    x.resize(static_cast<std::size_t>(std::min(kAtOnce, sound.n_samples - first)));
    sound.read(first, x);
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    lowest = std::min(lowest, *least);
    highest = std::max(highest, *most);
  }
  ClippingLimits limits;
  if (is_reached_again(lowest)) limits.lowest = lowest;
  if (is_reached_again(highest)) limits.highest = highest;
  return limits;
}

}  // namespace bouncelab::detection
