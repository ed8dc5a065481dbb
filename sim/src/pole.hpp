// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "bouncelab/sim/vector3.hpp"

namespace bouncelab {

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
    const double c = std::cos(rate_radps * t_s), s = std::sin(rate_radps * t_s);
    return {along + c * cosine + s * sine, (rate_radps * c) * sine - (rate_radps * s) * cosine};
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

}  // namespace bouncelab
