// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {

/// Deceleration by drag [m/s^2] at speed v >= 0:
///
///   d = (3/8) rho_air v^2 Cd / (rho R),   Cd = 24/Re (1 + 0.15 Re^0.687),   Re = 2 R v rho_air / mu
///
/// the factor by Schiller & Naumann (air.hpp); rho and R of the ball.
double drag_deceleration_mps2(const Ball& ball, const Air& air, double v_mps);

/// Speeds at the two ends of a vertical flight from the plate and back.
struct Flight {
  double launch_mps = 0.0;
  double landing_mps = 0.0;
};

/// The flight that lasts duration_s, with drag:
///
///   t_up = int_0^u dv/(g+d),  h = int_0^u v dv/(g+d) = int_0^w v dv/(g-d),  t_down = int_0^w dv/(g-d)
///
/// by Gauss-Legendre quadrature, u by iteration; relative error of both speeds below 1e-9 while d < g/3. Buoyancy and
/// added mass are neglected: they scale g and so both speeds alike (1.5e-4 for steel), not their ratio.
/// @param duration_s, gravity_mps2  > 0
Flight flight_with_drag(const Ball& ball, const Air& air, double duration_s, double gravity_mps2);

/// Landing speed after release at rest from a height, with drag.
double fall_with_drag_mps(const Ball& ball, const Air& air, double height_m, double gravity_mps2);

}  // namespace bouncelab::fit
