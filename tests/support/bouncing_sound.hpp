// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of a bouncing ball for the detector's tests, and the noise in them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"

namespace bouncelab::test {

struct BouncingSound {
  double rate_hz = 48e3;
  double first_s = 0.3;  // first impact
  double first_flight_s = 0.27;
  double eps = 0.975;
  double eps_scatter = 0.005;
  int n_impacts = 60;
  double amplitude = 0.5;  // of the first impact, proportional to the flight afterwards
  double noise_rms = 1e-3;
  double tail_s = 0.5;
  std::uint64_t seed = 1;
};

inline std::vector<double> impact_times(const BouncingSound& b) {
  Random random(b.seed, RandomStream::test, 0);
  std::vector<double> t{b.first_s};
  double flight_s = b.first_flight_s;
  for (int k = 1; k < b.n_impacts; ++k) {
    t.push_back(t.back() + flight_s);
    flight_s *= b.eps + b.eps_scatter * random.normal();
  }
  return t;
}

/// White noise.
inline void add_noise(std::vector<float>& x, double rms, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 1);
  for (float& sample : x) sample += static_cast<float>(rms * random.normal());
}

/// Noise as in a lived-in building: 6 dB less an octave higher, from 140 Hz on.
inline void add_low_noise(std::vector<float>& x, double rms, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 1);
  double last = 0.0;
  for (float& sample : x) sample += static_cast<float>(last = 0.98 * last + 0.2 * rms * random.normal());
}

/// Noise through one resonance, decaying: a clap, a key, a step.
inline void add_noise_burst(std::vector<float>& x, double rate_hz, double t_s, double amplitude, const Mode& resonance,
                            Random& random) {
  const double radius = std::exp(-kPi * 0.6 * resonance.f_hz / rate_hz);
  const double a1 = 2.0 * radius * std::cos(2.0 * kPi * resonance.f_hz / rate_hz);
  double y1 = 0.0, y2 = 0.0;
  const auto first = static_cast<std::size_t>(t_s * rate_hz);
  for (std::size_t n = first; n < std::min(x.size(), first + 8192); ++n) {
    const double y = (1.0 - radius) * random.normal() + a1 * y1 - radius * radius * y2;
    y2 = y1, y1 = y;
    x[n] += static_cast<float>(amplitude * y * std::exp(-static_cast<double>(n - first) / rate_hz / resonance.decay_s));
  }
}

/// One impact of a steel ball on a plate.
inline void add_impact(std::vector<float>& x, double rate_hz, double t_s, double amplitude) {
  add_modal_sound(x, rate_hz, t_s, amplitude, plate_impact());
}

inline std::vector<float> render(const BouncingSound& b) {
  const std::vector<double> t = impact_times(b);
  std::vector<float> x(static_cast<std::size_t>((t.back() + b.tail_s) * b.rate_hz));
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double flight_s = k == 0 ? b.first_flight_s : t[k] - t[k - 1];
    add_impact(x, b.rate_hz, t[k], b.amplitude * flight_s / b.first_flight_s);
  }
  add_noise(x, b.noise_rms, b.seed);
  return x;
}

}  // namespace bouncelab::test
