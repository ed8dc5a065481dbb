// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <vector>

#include "bouncelab/sim/flight.hpp"

namespace bouncelab::sim {

/// The centre's way without air.
class Parabola {
 public:
  Parabola(const BallState& start, Vector3 gravity_mps2)
      : y0_m_(start.clearance_m), v0_mps_(start.motion.velocity_mps.z), gravity_mps2_(gravity_mps2) {}

  double initial_velocity_mps() const { return v0_mps_; }
  /// Bound of the downward acceleration.
  double bend_mps2() const { return -gravity_mps2_.z; }
  double height_m(double t_s) const { return y0_m_ + t_s * (v0_mps_ - 0.5 * bend_mps2() * t_s); }
  double velocity_mps(double t_s) const { return v0_mps_ - bend_mps2() * t_s; }
  /// The last time at which the centre is at `level`; t where it is below already.
  double descent_to(double level_m, double t_s) const {
    const double y = height_m(t_s), v = velocity_mps(t_s), g = bend_mps2();
    if (y <= level_m) return t_s;
    const double root = std::sqrt(v * v + 2.0 * g * (y - level_m));
    return t_s + (v > 0.0 ? (v + root) / g : 2.0 * (y - level_m) / (root - v));
  }

  /// Place and velocity of the centre at t, from those at the start.
  void move(double t_s, BallState& state) const {
    const Vector3 v = state.motion.velocity_mps, g = gravity_mps2_;
    state.x_m += t_s * (v.x + 0.5 * g.x * t_s);
    state.y_m += t_s * (v.y + 0.5 * g.y * t_s);
    state.clearance_m += t_s * (v.z + 0.5 * g.z * t_s);
    state.motion.velocity_mps = v + t_s * g;
  }

 private:
  double y0_m_, v0_mps_;
  Vector3 gravity_mps2_;
};

/// The centre's way through air, from the start to below the plate. Integrated by the classical Runge-Kutta rule of
/// fourth order, read off between the steps by quintic Hermite polynomials, which match place, velocity and
/// acceleration at both ends.
///
/// Steps are 1/128 of the time from full speed to rest under gravity, and near the summit, where the drag's |v|^1.687
/// is not smooth, a quarter of the time to it. Error at the landing: some 1e-12 m for the paper's ball.
class DraggedPath {
 public:
  DraggedPath(const Ball& ball, const Air& air, const BallState& start, Vector3 gravity_mps2);

  double height_m(double t_s) const { return at(t_s).place_m.z; }
  double velocity_mps(double t_s) const { return at(t_s).velocity_mps.z; }
  /// The last time at which the centre is at `level`; t where it is below already.
  double descent_to(double level_m, double t_s) const;
  double initial_velocity_mps() const { return nodes_.front().velocity_mps.z; }
  /// Bound of the downward acceleration.
  double bend_mps2() const { return bend_mps2_; }

  /// Place (z: the clearance), velocity and acceleration of the centre.
  struct Node {
    double t_s;
    Vector3 place_m, velocity_mps, acceleration_mps2;
  };
  Node at(double t_s) const;

  /// Place and velocity of the centre at t.
  void move(double t_s, BallState& state) const;

 private:
  std::vector<Node> nodes_;
  double bend_mps2_;
};

}  // namespace bouncelab::sim
