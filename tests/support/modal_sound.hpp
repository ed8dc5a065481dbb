// SPDX-License-Identifier: GPL-3.0-or-later
// The tests' generator of sounds, independent of the project's synthesizer: damped modes that start at exact times.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::test {

/// level exp(-t / decay_s) sin(2 pi f_hz t + phase_rad)
struct Mode {
  double f_hz = 0.0;
  double decay_s = 0.0;
  double level = 1.0;
  double phase_rad = 0.0;
};

/// The sum of its modes, times 1 - exp(-(t / rise_s)^2).
struct ModalSound {
  std::vector<Mode> modes;
  double length_s = std::numeric_limits<double>::infinity();  ///< nothing after this
  double rise_s = 0.0;                                        ///< 0: it begins at once
};

/// Adds the sound, begun at t_s (which need not be a sample's time).
/// @param rate_hz  1: all times are in samples
inline void add_modal_sound(std::vector<float>& x, double rate_hz, double t_s, double amplitude,
                            const ModalSound& sound) {
  const auto first = static_cast<std::int64_t>(std::ceil(t_s * rate_hz));
  for (std::int64_t n = std::max<std::int64_t>(0, first); n < static_cast<std::int64_t>(x.size()); ++n) {
    const double t = static_cast<double>(n) / rate_hz - t_s;
    if (t > sound.length_s) break;
    double sum = 0.0;
    for (const Mode& mode : sound.modes)
      sum += mode.level * std::exp(-t / mode.decay_s) * std::sin(2.0 * kPi * mode.f_hz * t + mode.phase_rad);
    if (sound.rise_s > 0.0) sum *= 1.0 - std::exp(-t * t / (sound.rise_s * sound.rise_s));
    x[static_cast<std::size_t>(n)] += static_cast<float>(amplitude * sum);
  }
}

/// Modes of equal level and decay.
inline ModalSound equal_modes(const std::vector<double>& frequencies_hz, double decay_s, double length_s) {
  ModalSound sound{{}, length_s};
  for (const double f_hz : frequencies_hz) sound.modes.push_back({f_hz, decay_s});
  return sound;
}

/// A steel ball on a plate: eight modes from 2 to 12 kHz that decay in 1 to 4 ms.
inline ModalSound plate_impact() {
  ModalSound sound{{}, 30e-3};
  for (int m = 0; m < 8; ++m) sound.modes.push_back({2000.0 * std::pow(6.0, m / 7.0), 4e-3 - m * 0.4e-3, 0.25});
  return sound;
}

/// A soft ball on a floor: six modes from 250 to 1,600 Hz, at these levels.
inline constexpr int kThudModes = 6;
inline ModalSound thud(const std::array<double, kThudModes>& levels) {
  ModalSound sound{{}, 60e-3};
  for (int m = 0; m < kThudModes; ++m)
    sound.modes.push_back({250.0 * std::pow(6.4, m / 5.0), 6e-3, levels[static_cast<std::size_t>(m)]});
  return sound;
}

}  // namespace bouncelab::test
