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
/// Holds within 5 per cent for Re <= 800, which is 2 m/s for the paper's ball. Neglects added mass and buoyancy (1.5e-4
/// of gravity) and lift by spin. Source: Schiller & Naumann, VDI Zeitschrift 77, 318 (1933).
Vector3 drag_acceleration_mps2(const Ball& ball, const Air& air, Vector3 velocity_mps);

}  // namespace bouncelab::sim
