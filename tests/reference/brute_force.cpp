// SPDX-License-Identifier: GPL-3.0-or-later
#include "brute_force.hpp"

#include <array>
#include <cmath>

namespace bouncelab::sim::reference {
namespace {

/// gap(t) of one sphere of radius `radius_m` whose centre is at `arm_m` from the ball's (lab frame, t = 0).
struct Gap {
  double clearance_m, v_mps, g_mps2;
  Vector3 axis;
  double rate_radps;
  Vector3 arm_m;
  double sunk_m;  ///< radius of the sphere minus R

  double at(double t) const {
    const double c = std::cos(rate_radps * t), s = std::sin(rate_radps * t);
    const Vector3 turned = c * arm_m + s * cross(axis, arm_m) + ((1.0 - c) * dot(axis, arm_m)) * axis;  // eq. 4
    return (clearance_m + v_mps * t - 0.5 * g_mps2 * t * t) + (turned.z - sunk_m);
  }
  double slope(double t) const {
    const double c = std::cos(rate_radps * t), s = std::sin(rate_radps * t);
    const Vector3 across = cross(axis, arm_m);
    return v_mps - g_mps2 * t + rate_radps * (c * across.z - s * (arm_m.z - dot(axis, arm_m) * axis.z));
  }
  double bend() const { return g_mps2 + rate_radps * rate_radps * norm(arm_m); }
};

/// First t in [a, b] at which the gap is closed, by halving: a half is passed over where midpoint, slope and bend
/// exclude a zero in it.
std::optional<double> first_zero(const Gap& gap, double a, double b) {
  const double half = 0.5 * (b - a), middle = a + half;
  const double least = gap.at(middle) - std::abs(gap.slope(middle)) * half - 0.5 * gap.bend() * half * half;
  if (least > 0.0) return std::nullopt;
  if (half < 1e-16 + 1e-16 * b) return gap.at(b) <= 0.0 ? std::optional(b) : std::nullopt;
  if (const auto zero = first_zero(gap, a, middle)) return zero;
  return first_zero(gap, middle, b);
}

/// A span of time in which the ball is low enough to touch, with what its midpoint says of all asperities: the gap of
/// the one along u is there  height - R_j - R u.down,  its slope  v - R u.turning.
struct Window {
  double begin, end;
  double height_m, v_mps;
  Vector3 down, turning;

  double least_gap(const Ball& ball, const Asperity& asperity, double bend) const {
    const double half = 0.5 * (end - begin);
    const double gap = height_m - asperity.radius_m - ball.radius_m * dot(asperity.direction, down);
    const double slope = v_mps - ball.radius_m * dot(asperity.direction, turning);
    return gap - std::abs(slope) * half - 0.5 * bend * half * half;
  }
};

Window window(const Ball& ball, const BallState& start, double g, double begin, double end) {
  const double t = 0.5 * (begin + end);
  const Quaternion then = rotation_by(t * start.motion.spin_radps) * start.orientation;
  const Vector3 spin = rotate(conjugate(then), start.motion.spin_radps);
  const Vector3 down = -rotate(conjugate(then), {0, 0, 1});
  const double v = start.motion.velocity_mps.z;
  return {begin, end, ball.radius_m + start.clearance_m + v * t - 0.5 * g * t * t, v - g * t, down, cross(down, spin)};
}

/// Before it has risen above the highest asperity, and after it has come down to it again.
std::array<Window, 2> windows_of(const Ball& ball, const Surface& surface, const BallState& start, double g,
                                 double t_smooth) {
  double highest_m = 0.0;
  for (const Asperity& asperity : surface.asperities) highest_m = std::max(highest_m, asperity.radius_m);
  const double v = start.motion.velocity_mps.z;
  const double inside = v * v + 2.0 * g * (start.clearance_m - highest_m);
  const double root = std::sqrt(std::max(0.0, inside));
  const double up = inside > 0.0 ? std::max(0.0, (v - root) / g) : t_smooth;
  const double down = inside > 0.0 ? std::max(0.0, (v + root) / g) : t_smooth;
  return {window(ball, start, g, 0.0, up), window(ball, start, g, down, t_smooth)};
}

}  // namespace

FirstContact first_contact(const Ball& ball, const Surface& surface, const BallState& start, double gravity_mps2,
                           std::optional<std::int64_t> left) {
  const double y = start.clearance_m, v = start.motion.velocity_mps.z, g = gravity_mps2;
  const double rate = norm(start.motion.spin_radps);
  const Vector3 axis = rate > 0.0 ? normalized(start.motion.spin_radps) : Vector3{1, 0, 0};
  const double t_smooth = (v + std::sqrt(v * v + 2.0 * g * y)) / g;
  const double bend = g + rate * rate * ball.radius_m;
  FirstContact first{t_smooth, -1, {0, 0, -ball.radius_m}, start};
  for (const Window& span : windows_of(ball, surface, start, g, t_smooth)) {
    for (std::size_t j = 0; j < surface.asperities.size(); ++j) {
      const Asperity& asperity = surface.asperities[j];
      // a margin for the midpoint's rounding: 1e-15 m
      if (span.least_gap(ball, asperity, bend) > 1e-15) continue;
      const Gap gap{y,
                    v,
                    g,
                    axis,
                    rate,
                    ball.radius_m * rotate(start.orientation, asperity.direction),
                    asperity.radius_m - ball.radius_m};
      // just left: opens with slope(0), so closed again not before 2 slope/bend
      const double excluded = left == static_cast<std::int64_t>(j) ? gap.slope(0.0) / gap.bend() : 0.0;
      const double begin = std::max(span.begin, excluded), end = std::min(span.end, first.dt_s);
      if (begin >= end) continue;
      if (const auto zero = first_zero(gap, begin, end)) {
        first.dt_s = *zero;
        first.asperity = static_cast<std::int64_t>(j);
      }
    }
  }
  const double t = first.dt_s;
  first.state.x_m += start.motion.velocity_mps.x * t;
  first.state.y_m += start.motion.velocity_mps.y * t;
  first.state.clearance_m += v * t - 0.5 * g * t * t;
  first.state.motion.velocity_mps.z -= g * t;
  first.state.orientation = normalized(rotation_by(t * start.motion.spin_radps) * start.orientation);
  if (first.asperity >= 0) {
    const Asperity& asperity = surface.asperities[static_cast<std::size_t>(first.asperity)];
    first.lever_m =
        ball.radius_m * rotate(first.state.orientation, asperity.direction) - Vector3{0, 0, asperity.radius_m};
  }
  return first;
}

Motion collide_paper(const Ball& ball, const RestitutionLaw& law, double beta, Vector3 r, const Motion& before) {
  const double m = mass_kg(ball), j = moment_of_inertia_kgm2(ball);
  const Vector3 v = before.velocity_mps + cross(before.spin_radps, r);
  const double d[3] = {(beta - 1.0) * v.x, (beta - 1.0) * v.y, -(1.0 + restitution(law, std::abs(v.z))) * v.z};
  const double rr[3] = {r.x, r.y, r.z};
  double a[3][4];
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) a[row][col] = (row == col ? 1.0 / m + norm2(r) / j : 0.0) - rr[row] * rr[col] / j;
    a[row][3] = d[row];
  }
  for (int p = 0; p < 3; ++p) {  // Gauss-Jordan; positive definite, no pivoting needed
    for (int row = 0; row < 3; ++row) {
      if (row == p) continue;
      const double f = a[row][p] / a[p][p];
      for (int col = p; col < 4; ++col) a[row][col] -= f * a[p][col];
    }
  }
  const Vector3 impulse{a[0][3] / a[0][0], a[1][3] / a[1][1], a[2][3] / a[2][2]};
  return {before.velocity_mps + (1.0 / m) * impulse, before.spin_radps + (1.0 / j) * cross(r, impulse)};
}

BallState state_after(const Ball& ball, const ImpactState& s) {
  const auto vector = [](const std::array<double, 3>& a) { return Vector3{a[0], a[1], a[2]}; };
  return {s.position_m[0], s.position_m[1], s.position_m[2] - ball.radius_m,
          Quaternion{s.orientation[0], s.orientation[1], s.orientation[2], s.orientation[3]},
          Motion{vector(s.velocity_after_mps), vector(s.spin_after_radps)}};
}

}  // namespace bouncelab::sim::reference
