// SPDX-License-Identifier: GPL-3.0-or-later
// A small sound generator for the detector's tests, independent of the project's synthesizer: damped modes started at
// exact times, white noise.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/units.hpp"

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

/// Adds one impact: eight modes from 2 to 12 kHz, each a sine that starts at t_s and decays in 1 to 4 ms.
inline void add_impact(std::vector<float>& x, double rate_hz, double t_s, double amplitude) {
  const auto first = static_cast<std::int64_t>(std::ceil(t_s * rate_hz));
  for (std::int64_t n = std::max<std::int64_t>(0, first); n < static_cast<std::int64_t>(x.size()); ++n) {
    const double dt = static_cast<double>(n) / rate_hz - t_s;
    if (dt > 30e-3) break;
    double sum = 0.0;
    for (int m = 0; m < 8; ++m) {
      const double f_hz = 2000.0 * std::pow(6.0, m / 7.0);
      sum += std::exp(-dt / (4e-3 - m * 0.4e-3)) * std::sin(2.0 * kPi * f_hz * dt);
    }
    x[static_cast<std::size_t>(n)] += static_cast<float>(amplitude * sum / 4.0);
  }
}

inline void add_noise(std::vector<float>& x, double rms, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 1);
  for (float& sample : x) sample += static_cast<float>(rms * random.normal());
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
