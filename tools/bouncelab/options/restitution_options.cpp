// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/restitution_command.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void add_restitution_options(CLI::App& app, RestitutionOptions& options) {
  app.option_defaults()->group("Coefficients of restitution");
  app.add_option("--gravity", options.config.gravity_mps2, "Gravity [m/s^2]")->check(within(1e-3, 1e3));
  app.add_flag("--correct-drag", options.config.correct_drag, "Correct for air drag; needs --ball");
  app.add_flag("--correct-contact-time", options.config.correct_contact_time,
               "Correct each interval for the time of contact; needs --ball and --plate");
  app.add_option("--drop-height", options.drop_height_m,
                 "Height of the ball's lowest point at release [m], 0 = not known; the first impact counts then")
      ->check(within(0.0, 1e3));
  app.add_option("--positions", options.positions,
                 "Table drop,impact,x_m,y_m (as simulate --state writes): correct for the travel of the sound");
  add_list(app, "--sensor-position", options.sensor_m, "X,Y", 2, 2, -1e3, 1e3, "Position of the sensor [m]");
  app.add_option("--wave-speed", options.wave_speed_mps,
                 "Speed of the sound from impact to sensor [m/s]: some 2500 in a plate, 343 in air")
      ->check(within(1.0, 2e4));
}

Command add_restitution_command(CLI::App& app) {
  auto options = std::make_shared<RestitutionOptions>();
  CLI::App* command = app.add_subcommand(
      "restitution", "Coefficients of restitution from impact times: ratios of neighbouring intervals");
  command->footer(
      "Example: bouncelab restitution onsets.csv --out samples.csv\n"
      "         bouncelab restitution monday.csv tuesday.csv --out samples.csv");
  command
      ->add_option("onsets", options->onsets,
                   "Onsets, as detect writes them; a column t_s is enough. Several files are taken in this order; rows "
                   "without a recording are of one that is called like the file")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Samples, .csv")->type_name("FILE")->required();
  add_ball_options(*command, options->world,
                   "those of the onsets' .meta.json where they were simulated, else not known: drag and contact time "
                   "stay open");
  add_restitution_options(*command, *options);
  return {command, [options](Run& run) {
            options->world = with_provenance(options->world, options->onsets);
            set_parameter(run.parameters, "ball", options->world.ball);
            set_parameter(run.parameters, "plate", options->world.plate);
            return run_restitution(*options, run).outcome;
          }};
}

}  // namespace bouncelab::cli
