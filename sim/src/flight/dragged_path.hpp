// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/sim/drag.hpp"
#include "bouncelab/sim/flight.hpp"

namespace bouncelab::sim {

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
