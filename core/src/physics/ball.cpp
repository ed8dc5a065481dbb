// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/ball.hpp"

#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab {

double mass_kg(const Ball& ball) {
  return 4.0 / 3.0 * std::numbers::pi * ball.radius_m * ball.radius_m * ball.radius_m * ball.material.density_kgpm3;
}

double moment_of_inertia_kgm2(const Ball& ball) {
  return ball.inertia_factor * mass_kg(ball) * ball.radius_m * ball.radius_m;
}

double shell_inertia_factor(double mean_density_kgpm3, double shell_density_kgpm3) {
  const double filled = mean_density_kgpm3 / shell_density_kgpm3;  // share of the volume
  return 0.4 * (1.0 - pow(1.0 - filled, 5.0 / 3.0)) / filled;
}

double no_slip_factor(double inertia_factor) { return 1.0 / (1.0 + inertia_factor); }

std::optional<double> contact_time_s(const Ball& ball, const Material& plate, double v_mps) {
  if (ball.contact_time_s) return ball.contact_time_s;
  if (!ball.material.hertzian || !plate.hertzian) return std::nullopt;
  return hertz_contact_time_s(ball, plate, v_mps);
}

namespace {

/// 15 m / (16 E* sqrt R): the greatest compression is (this v^2)^(2/5) [m^(5/2) s^2/m^2].
double hertz_scale(const Ball& ball, const Material& plate) {
  const auto compliance = [](const Material& m) {
    return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus_pa;
  };
  const double effective_modulus_pa = 1.0 / (compliance(ball.material) + compliance(plate));
  return 15.0 * mass_kg(ball) / (16.0 * effective_modulus_pa * std::sqrt(ball.radius_m));
}

}  // namespace

double hertz_contact_time_s(const Ball& ball, const Material& plate, double v_mps) {
  return 2.943 * pow(hertz_scale(ball, plate), 0.4) * pow(v_mps, -0.2);
}

double hertz_patch_radius_m(const Ball& ball, const Material& plate, double v_mps) {
  if (v_mps == 0.0) return 0.0;
  return std::sqrt(ball.radius_m * pow(hertz_scale(ball, plate) * v_mps * v_mps, 0.4));
}

}  // namespace bouncelab
