// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/patch.hpp"

#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::sim {
namespace {

constexpr int kCirclePoints = 256;

}  // namespace

Vector3 mean_gradient(const Envelope& envelope, Vector3 n, double alpha_rad) {
  // any two axes across n; the smallest component of n is furthest from parallel
  const Vector3 helper = std::abs(n.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  const Vector3 e1 = normalized(cross(n, helper)), e2 = cross(n, e1);
  const SinCos alpha = sin_cos(alpha_rad);
  Vector3 sum;
  for (int k = 0; k < kCirclePoints; ++k) {
    const SinCos phi = sin_cos(2.0 * kPi * k / kCirclePoints);
    const Vector3 outwards = phi.cos * e1 + phi.sin * e2;
    sum = sum + envelope.support(normalized(alpha.cos * n + alpha.sin * outwards)).elevation * outwards;
  }
  return (2.0 / (kCirclePoints * alpha.sin)) * sum;
}

Vector3 patch_lever_m(const Ball& ball, const Material& plate, const Envelope& envelope, const FirstContact& contact) {
  const double speed_mps = std::abs(contact.state.motion.velocity_mps.z);
  const double alpha_rad = hertz_patch_radius_m(ball, plate, speed_mps) / ball.radius_m;
  if (!(alpha_rad > 0.0)) return contact.lever_m;
  const Quaternion q = contact.state.orientation;
  const Vector3 n = normalized(rotate(conjugate(q), {0, 0, -1}));
  const Vector3 offset = rotate(q, mean_gradient(envelope, n, alpha_rad));
  return {ball.radius_m * offset.x, ball.radius_m * offset.y, contact.lever_m.z};
}

}  // namespace bouncelab::sim
