// SPDX-License-Identifier: GPL-3.0-or-later
#include "flight/contact_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"

namespace bouncelab::sim {
namespace {

using PathNode = DraggedPath::Node;

/// Shortest step: at the summit itself. The drag of what rises and falls back within a thousandth of the flight's time
/// from there moves the ball by less than 1e-13 m.
constexpr double kShortestStep_s = 1e-7, kShortestOfFall = 1e-3;

template <class Acceleration>
PathNode stepped(const PathNode& from, double h, const Acceleration& acceleration) {
  const Vector3 v1 = from.velocity_mps, a1 = from.acceleration_mps2;
  const Vector3 v2 = v1 + (0.5 * h) * a1, a2 = acceleration(v2);
  const Vector3 v3 = v1 + (0.5 * h) * a2, a3 = acceleration(v3);
  const Vector3 v4 = v1 + h * a3, a4 = acceleration(v4);
  const Vector3 v = v1 + (h / 6.0) * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  const Vector3 x = from.place_m + (h / 6.0) * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
  return {from.t_s + h, x, v, acceleration(v)};
}

/// Quintic Hermite interpolation between two nodes, and its derivative.
PathNode between(const PathNode& p, const PathNode& q, double t) {
  const double h = q.t_s - p.t_s, s = (t - p.t_s) / h;
  // in powers of s: x = x0 + h v0 s + h^2 a0 s^2/2 + c3 s^3 + c4 s^4 + c5 s^5
  const Vector3 rest = q.place_m - p.place_m - h * p.velocity_mps - (0.5 * h * h) * p.acceleration_mps2;
  const Vector3 slope = h * (q.velocity_mps - p.velocity_mps) - (h * h) * p.acceleration_mps2;
  const Vector3 bend = (h * h) * (q.acceleration_mps2 - p.acceleration_mps2);
  const Vector3 c3 = 10.0 * rest - 4.0 * slope + 0.5 * bend;
  const Vector3 c4 = -15.0 * rest + 7.0 * slope - bend;
  const Vector3 c5 = 6.0 * rest - 3.0 * slope + 0.5 * bend;
  const double s2 = s * s;
  const Vector3 x = p.place_m + (h * s) * p.velocity_mps + (0.5 * h * h * s2) * p.acceleration_mps2 +
                    (s * s2) * (c3 + s * c4 + s2 * c5);
  const Vector3 v =
      p.velocity_mps + (h * s) * p.acceleration_mps2 + (s2 / h) * (3.0 * c3 + (4.0 * s) * c4 + (5.0 * s2) * c5);
  return {t, x, v, p.acceleration_mps2};
}

}  // namespace

Vector3 drag_acceleration_mps2(const Ball& ball, const Air& air, Vector3 velocity_mps) {
  return -drag_rate_per_s(ball, air, norm(velocity_mps)) * velocity_mps;
}

DraggedPath::DraggedPath(const Ball& ball, const Air& air, const BallState& start, Vector3 gravity_mps2) {
  const auto acceleration = [&](Vector3 v) { return gravity_mps2 + drag_acceleration_mps2(ball, air, v); };
  const Vector3 v = start.motion.velocity_mps;
  const double g = -gravity_mps2.z;
  nodes_.reserve(100);
  nodes_.push_back({0.0, {start.x_m, start.y_m, start.clearance_m}, v, acceleration(v)});
  const double fall_s = std::sqrt(v.z * v.z + 2.0 * g * std::max(0.0, start.clearance_m)) / g;
  const double shortest_s = std::max(kShortestStep_s, kShortestOfFall * fall_s);
  while (nodes_.back().place_m.z > 0.0 || nodes_.back().velocity_mps.z > 0.0 || nodes_.size() < 2) {
    const double to_summit_s = std::abs(nodes_.back().velocity_mps.z) / g;
    const double h = std::clamp(0.25 * to_summit_s, shortest_s, std::max(shortest_s, fall_s / 32.0));
    nodes_.push_back(stepped(nodes_.back(), h, acceleration));
  }
  // drag adds to gravity only on the way up, where the start is fastest
  bend_mps2_ = g + norm(nodes_.front().acceleration_mps2 - gravity_mps2);
}

DraggedPath::Node DraggedPath::at(double t_s) const {
  auto after = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, t_s,
                                [](double t, const Node& node) { return t < node.t_s; });
  return between(*(after - 1), *after, t_s);
}

void DraggedPath::move(double t_s, BallState& state) const {
  const Node node = at(t_s);
  state.x_m = node.place_m.x;
  state.y_m = node.place_m.y;
  state.clearance_m = node.place_m.z;
  state.motion.velocity_mps = node.velocity_mps;
}

double DraggedPath::descent_to(double level_m, double t_s) const {
  if (height_m(t_s) <= level_m) return t_s;
  // nodes from the end of the path up to the first that is at or above the level
  std::size_t k = nodes_.size() - 1;
  while (k > 0 && nodes_[k].place_m.z < level_m) --k;
  double t = nodes_[k].t_s;
  for (int i = 0; i < 50; ++i) {  // Newton from above on a concave arc: overshoots once at the most, then from below
    const Node here = at(t);
    if (!(here.velocity_mps.z < 0.0)) {
      t += kShortestStep_s;
      continue;
    }
    const double step = (level_m - here.place_m.z) / here.velocity_mps.z;
    t += step;
    if (std::abs(step) < 1e-16 + 2e-16 * t) break;
  }
  return std::max(t, t_s);
}

namespace {

template <class Path>
FirstContact contact_on(Path path, const Ball& ball, const Envelope& envelope, const BallState& start,
                        std::optional<std::int64_t> left) {
  ContactSearch<Path> search(ball, envelope, start, std::move(path), left);
  while (!search.find_leaf()) {
  }
  return search.find_contact();
}

}  // namespace

FirstContact find_first_contact(const Ball& ball, const Envelope& envelope, const BallState& start,
                                Vector3 gravity_mps2, std::optional<std::int64_t> left, const std::optional<Air>& air) {
  if (!(gravity_mps2.z < 0.0))
    throw InvalidArgument("flight: gravity must pull towards the plate, its normal part is " +
                          std::to_string(gravity_mps2.z) + " m/s^2; tilt the plate less");
  if (air) return contact_on(DraggedPath(ball, *air, start, gravity_mps2), ball, envelope, start, left);
  return contact_on(Parabola(start, gravity_mps2), ball, envelope, start, left);
}

Vector3 mean_gradient(const Envelope& envelope, Vector3 n, double alpha_rad) {
  constexpr int kCirclePoints = 256;
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
