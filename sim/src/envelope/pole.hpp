// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

/// The body-fixed direction that points at the plate, n(t) = -A(t)^T e_z. Angular velocity is constant in the lab,
/// hence in the body too, and n runs on a circle: n' = n x Omega, Omega = A^T omega.
struct Pole {
  Vector3 along, cosine, sine;  ///< n = along + cosine cos(rate t) + sine sin(rate t)
  double rate_radps = 0.0;      ///< |Omega|
  double speed_radps = 0.0;     ///< |n'|, constant

  struct Instant {
    Vector3 direction, velocity;
  };
  Instant at(double t_s) const {
    const auto [c, s] = turn(rate_radps * t_s);
    return {along + c * cosine + s * sine, (rate_radps * c) * sine - (rate_radps * s) * cosine};
  }

  /// n at t = 0.
  Vector3 direction() const { return along + cosine; }

  /// The same motion with its clock set back to 0 at t.
  Pole from(double t_s) const {
    const auto [c, s] = turn(rate_radps * t_s);
    return {along, c * cosine + s * sine, c * sine - s * cosine, rate_radps, speed_radps};
  }

 private:
  struct Turn {
    double cosine, sine;
  };
  static Turn turn(double angle) {
    if (angle > 0.01) {
      const SinCos exact = sin_cos(angle);
      return {exact.cos, exact.sin};
    }
    // the next terms of the series are below 2e-18
    const double a2 = angle * angle;
    return {1.0 - a2 * (0.5 - a2 * (1.0 / 24.0 - a2 * (1.0 / 720.0))),
            angle * (1.0 - a2 * (1.0 / 6.0 - a2 * (1.0 / 120.0)))};
  }
};

inline Pole make_pole(Quaternion orientation, Vector3 spin_radps) {
  const Quaternion to_body = conjugate(orientation);
  const Vector3 n = -rotate(to_body, {0, 0, 1});
  const double rate = norm(spin_radps);
  if (rate == 0.0) return {{}, n, {}, 0.0, 0.0};
  const Vector3 axis = normalized(rotate(to_body, spin_radps));
  const Vector3 along = dot(axis, n) * axis;
  const Vector3 sine = cross(n, axis);
  return {along, n - along, sine, rate, rate * norm(sine)};
}

}  // namespace bouncelab::sim
