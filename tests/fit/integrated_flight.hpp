// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace bouncelab::testing {

struct IntegratedFlight {
  double duration_s, landing_mps;
};

/// A flight under drag by brute force, sharing nothing with the program: Runge-Kutta of fourth order in steps of the
/// flight's n-th part, the landing by the last step's parabola.
/// @param deceleration  by drag, of the speed
template <class Deceleration>
IntegratedFlight integrated_flight(double launch_mps, double g_mps2, int n_steps, Deceleration deceleration) {
  double z = 0.0, v = launch_mps, t = 0.0;
  const double h = 2.0 * launch_mps / g_mps2 / n_steps;
  const auto a = [&](double w) { return -g_mps2 - std::copysign(deceleration(std::abs(w)), w); };
  for (;;) {
    const double k1 = a(v), k2 = a(v + 0.5 * h * k1), k3 = a(v + 0.5 * h * k2), k4 = a(v + h * k3);
    const double dz = h * (v + h * (k1 + k2 + k3) / 6.0), dv = h * (k1 + 2 * k2 + 2 * k3 + k4) / 6.0;
    if (z + dz < 0.0) break;
    z += dz;
    v += dv;
    t += h;
  }
  const double acceleration = a(v);
  const double rest = (v + std::sqrt(v * v - 2.0 * acceleration * z)) / -acceleration;  // v < 0: time to z = 0
  return {t + rest, -(v + acceleration * rest)};
}

}  // namespace bouncelab::testing
