// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

/// The circle in which a plane through the ball's centre cuts an asperity. Its centre is on the ball's circle but for
/// radius^2 / (2 R).
struct SectionCircle {
  double angle_rad = 0.0;  ///< of its centre along the ball's circle
  double radius_m = 0.0;   ///< sqrt(R_j^2 - d^2), d the distance of the asperity's centre from the plane
};

/// A piece of the ball as it looks when cut through its centre, for a picture of its surface.
struct BallSection {
  double ball_radius_m = 0.0;
  std::size_t n_asperities = 0;         ///< of the whole ball
  double mean_asperity_radius_m = 0.0;  ///< likewise
  double half_angle_rad = 0.0;          ///< the piece reaches from minus to plus this; at most a quarter of the circle
  std::vector<SectionCircle> circles;   ///< by angle
};

/// The piece around the z axis of the body frame in the plane y = 0, so long that some 10 asperities are cut by it (of
/// directions uniform on the sphere the plane cuts R_j / (2 pi R) of them in each radian).
BallSection section_of(const Ball& ball, const Surface& surface);

}  // namespace bouncelab::sim
