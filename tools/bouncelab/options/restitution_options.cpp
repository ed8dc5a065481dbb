// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/restitution_command.hpp"
#include "options/commands.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void add_restitution_options(CLI::App& app, RestitutionOptions& options) {
  app.add_option("--gravity", options.config.gravity_mps2, "Gravity, m/s^2")->check(within(1e-3, 1e3));
  app.add_flag("--correct-drag", options.config.correct_drag, "Correct for air drag (radius and density of the ball)");
  app.add_flag("--correct-contact-time", options.config.correct_contact_time,
               "Correct each interval for the Hertz contact (steel on glass)");
  app.add_option("--drop-height", options.drop_height_m,
                 "Height of the ball's lowest point at release, m, 0 = not known; the first impact counts then")
      ->check(within(0.0, 1e3));
  app.add_option("--positions", options.positions,
                 "Table drop,impact,x_m,y_m (as simulate --state writes): correct for the travel of the sound");
  add_list(app, "--sensor-position", options.sensor_m, "X,Y", 2, 2, -1e3, 1e3, "Position of the sensor, m");
  app.add_option("--wave-speed", options.wave_speed_mps,
                 "Speed of the sound from impact to sensor, m/s: some 2500 in a plate, 343 in air")
      ->check(within(1.0, 2e4));
  app.add_option("--ball-radius", options.config.ball.radius_m,
                 "Radius of the ball, m: for the corrections and the error budget")
      ->check(within(1e-6, 10.0));
  app.add_option("--ball-density", options.config.ball.material.density_kgpm3, "Density of the ball, kg/m^3: likewise")
      ->check(within(1.0, 3e4));
}

Command add_restitution_command(CLI::App& app) {
  auto options = std::make_shared<RestitutionOptions>();
  CLI::App* command = app.add_subcommand("restitution",
                                         "Coefficients of restitution from impact times: ratios of neighbouring "
                                         "intervals\n"
                                         "Example: bouncelab restitution onsets.csv --out samples.csv");
  command->add_option("onsets", options->onsets, "Onsets, as detect writes them; a column t_s is enough")->required();
  command->add_option("--out", options->out, "Samples, .csv")->required();
  add_restitution_options(*command, *options);
  return {command, [options](Run& run) { return run_restitution(*options, run).outcome; }};
}

}  // namespace bouncelab::cli
