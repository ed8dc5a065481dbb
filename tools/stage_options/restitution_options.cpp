// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/restitution_options.hpp"

namespace bouncelab::options {

Description members_of(const RestitutionOptions*) {
  using O = RestitutionOptions;
  static constexpr Member options[]{
      member<&O::positions>(
          "positions", "Table drop,impact,x_m,y_m (as simulate --state writes): correct for the travel of the sound"),
      member<&O::sensor_m>("sensor_position", "Position of the sensor [m]").with_commas("X,Y", 2, 2).within(-1e3, 1e3)};
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
