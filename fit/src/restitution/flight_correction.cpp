// SPDX-License-Identifier: GPL-3.0-or-later
#include "restitution/flight_correction.hpp"

#include <cmath>

#include "bouncelab/core/numerics.hpp"

namespace bouncelab::fit {
namespace {

struct Leg {
  double duration_s = 0.0;
  double height_m = 0.0;
};

/// From rest to speed v or back; drag helps to stop on the way up (sign +1) and holds up on the way down (-1).
Leg leg(const Ball& ball, const Air& air, double v_mps, double gravity_mps2, double sign) {
  Leg result;
  static const QuadratureRule rule = gauss_legendre(6, 0.0, 1.0);
  for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
    const double v = v_mps * rule.nodes[k];
    const double weight = v_mps * rule.weights[k] / (gravity_mps2 + sign * drag_deceleration_mps2(ball, air, v));
    result.duration_s += weight;
    result.height_m += weight * v;
  }
  return result;
}

}  // namespace

double drag_deceleration_mps2(const Ball& ball, const Air& air, double v_mps) {
  const double reynolds = 2.0 * ball.radius_m * v_mps * air.density_kgpm3 / air.viscosity_pas;
  const double stokes = 4.5 * air.viscosity_pas * v_mps / (ball.material.density_kgpm3 * ball.radius_m * ball.radius_m);
  return stokes * schiller_naumann_factor(reynolds);
}

double fall_with_drag_mps(const Ball& ball, const Air& air, double height_m, double gravity_mps2) {
  double v = std::sqrt(2.0 * gravity_mps2 * height_m);
  // h goes nearly as v^2: the square root is nearly Newton's step
  for (int i = 0; i < 8; ++i) {
    const double ratio = std::sqrt(height_m / leg(ball, air, v, gravity_mps2, -1.0).height_m);
    v *= ratio;
    if (std::abs(ratio - 1.0) < 1e-12) break;
  }
  return v;
}

Flight flight_with_drag(const Ball& ball, const Air& air, double duration_s, double gravity_mps2) {
  Flight flight;
  flight.launch_mps = 0.5 * gravity_mps2 * duration_s;
  for (int i = 0; i < 8; ++i) {
    const Leg up = leg(ball, air, flight.launch_mps, gravity_mps2, 1.0);
    flight.landing_mps = fall_with_drag_mps(ball, air, up.height_m, gravity_mps2);
    const double total_s = up.duration_s + leg(ball, air, flight.landing_mps, gravity_mps2, -1.0).duration_s;
    const double ratio = duration_s / total_s;
    flight.launch_mps *= ratio;
    if (std::abs(ratio - 1.0) < 1e-12) break;
  }
  return flight;
}

}  // namespace bouncelab::fit
