// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/air.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

/// Acceleration by the drag on a sphere of diameter d:
///
///   a = -(18 mu / (rho d^2)) (1 + 0.15 Re^0.687) v,   Re = rho_air |v| d / mu,   rho the ball's density
///
/// the factor by Schiller & Naumann (air.hpp). Neglects added mass and buoyancy (1.5e-4 of gravity) and lift by spin.
Vector3 drag_acceleration_mps2(const Ball& ball, const Air& air, Vector3 velocity_mps);

}  // namespace bouncelab::sim
