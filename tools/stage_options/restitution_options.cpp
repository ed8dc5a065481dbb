// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/restitution_options.hpp"

namespace bouncelab::options {

const Description& members_of(const RestitutionOptions*) {
  using O = RestitutionOptions;
  static const Description options{
      member<O>(
          "gravity", [](auto& o) -> auto& { return o.config.gravity_mps2; }, "Gravity [m/s^2]")
          .within(1e-3, 1e3),
      member<O>(
          "air", [](auto& o) -> auto& { return o.config.air_kgpm3; },
          "Density of the air [kg/m^3]; 0 = none, and contacts take no time: for simulations")
          .within(0.0, 1e3),
      member<O>(
          "drop_height", [](auto& o) -> auto& { return o.config.drop_height_m; },
          "Height of the ball's lowest point at release [m], 0 = not known; the first impact counts then")
          .within(0.0, 1e3)
          .unknown_as("0"),
      member("positions", &O::positions,
             "Table drop,impact,x_m,y_m (as simulate --state writes): correct for the travel of the sound"),
      member("sensor_position", &O::sensor_m, "Position of the sensor [m]").with_commas("X,Y", 2, 2).within(-1e3, 1e3),
      member<O>(
          "wave_speed", [](auto& o) -> auto& { return o.config.wave_speed_mps; },
          "Speed of the sound from impact to sensor [m/s]: some 2500 in a plate, 343 in air")
          .within(1.0, 2e4)};
  return options;
}

fit::RestitutionConfig with_ball(const RestitutionOptions& options) {
  fit::RestitutionConfig config = options.config;
  if (config.air_kgpm3 == 0.0) config.instant_contacts = true;
  if (const std::optional<Ball> ball = ball_of(options.world)) config.ball = ball;
  if (const std::optional<Material> plate = plate_of(options.world)) config.plate = plate;
  return config;
}

}  // namespace bouncelab::options
