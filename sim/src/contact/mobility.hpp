// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/ball.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

/// Response of the contact point's velocity to an impulse: K = a I - r r^T / J, a = 1/m + |r|^2/J.
struct Mobility {
  Mobility(const Ball& ball, Vector3 lever_m)
      : r(lever_m), m(mass_kg(ball)), j(moment_of_inertia_kgm2(ball)), a(1.0 / m + norm2(r) / j) {}

  Vector3 velocity_change(Vector3 impulse) const { return a * impulse - (dot(r, impulse) / j) * r; }
  Vector3 impulse_for(Vector3 change) const { return (1.0 / a) * (change + (m / j * dot(r, change)) * r); }

  Vector3 r;
  double m, j, a;
};

}  // namespace bouncelab::sim
