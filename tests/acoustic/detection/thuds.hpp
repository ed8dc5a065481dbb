// SPDX-License-Identifier: GPL-3.0-or-later
// Sounds of soft balls in a room for the detector's tests: low modes in changing shares, coloured noise.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::test {

/// A dull thud: modes from 250 to 1,600 Hz, in shares.
inline constexpr int kModes = 6;
using Shares = std::array<double, kModes>;
inline void add_thud(std::vector<float>& x, double rate_hz, double t_s, double amplitude, const Shares& shares) {
  for (int m = 0; m < kModes; ++m) {
    const double f_hz = 250.0 * std::pow(6.4, m / 5.0);
    const double share = amplitude * shares[static_cast<std::size_t>(m)];
    for (auto n = static_cast<std::size_t>(std::ceil(t_s * rate_hz)); n < x.size(); ++n) {
      const double dt = static_cast<double>(n) / rate_hz - t_s;
      if (dt > 60e-3) break;
      x[n] += static_cast<float>(share * std::exp(-dt / 6e-3) * std::sin(2.0 * kPi * f_hz * dt));
    }
  }
}

/// Noise of a room: 6 dB less an octave higher, from 140 Hz on.
inline void add_room_noise(std::vector<float>& x, double rms, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 1);
  double last = 0.0;
  for (float& sample : x) sample += static_cast<float>(last = 0.98 * last + 0.2 * rms * random.normal());
}

}  // namespace bouncelab::test
