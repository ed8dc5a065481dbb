// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "commands/restitution_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

const Description& members_of(const RestitutionOptions*) {
  using O = RestitutionOptions;
  static const Description options{
      member<O>(
          "gravity", [](auto& o) -> auto& { return o.config.gravity_mps2; }, "Gravity [m/s^2]")
          .within(1e-3, 1e3),
      member<O>(
          "correct_drag", [](auto& o) -> auto& { return o.config.correct_drag; }, "Correct for air drag; needs --ball"),
      member<O>(
          "correct_contact_time", [](auto& o) -> auto& { return o.config.correct_contact_time; },
          "Correct each interval for the time of contact; needs --ball and --plate"),
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

Command restitution_command() {
  using O = RestitutionOptions;
  static const Description files{
      member("onsets", &O::onsets,
             "Onsets, as detect writes them; a column t_s is enough. Several files are taken in this order; rows "
             "without a recording are of one that is called like the file")
          .required()
          .positional(),
      member("out", &O::out, "Samples, .csv").looks_like("FILE").required()};
  static const Description ball = ball_options(
      "those of the onsets' .meta.json where they were simulated, else not known: drag and contact time stay open");
  auto options = std::make_shared<O>();
  return {"restitution",
          "Coefficients of restitution from impact times: ratios of neighbouring intervals",
          "Example: bouncelab restitution onsets.csv --out samples.csv\n"
          "         bouncelab restitution monday.csv tuesday.csv --out samples.csv",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Coefficients of restitution", &members_of(options.get()), options.get()}},
          [options](Run& run) {
            options->world = with_provenance(options->world, options->onsets);
            set_parameter(run.parameters, "ball", options->world.ball);
            set_parameter(run.parameters, "plate", options->world.plate);
            return run_restitution(*options, run).outcome;
          }};
}

}  // namespace bouncelab::cli
