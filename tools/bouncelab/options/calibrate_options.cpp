// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/calibrate_command.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void add_calibrate_options(CLI::App& app, CalibrateOptions& options) {
  fit::CalibrationConfig& c = options.config;
  app.add_option("--samples", c.n_samples, "Samples per seed")->check(within(100, 100000000));
  app.add_option("--seeds", c.n_seeds, "Seeds")->check(within(2, 1000000));
  app.add_option("--offset-variance", c.offset_variance,
                 "Mean square offset of the contact point over the ball's radius, each component: sets the scatter")
      ->check(within(1e-9, 1e-3));
  app.add_option("--timing", c.sigma_eps_at_1mps,
                 "Timing error of eps at 1 m/s; 8.7e-4 is as wide as the scatter at 0.3 m/s")
      ->check(within(0.0, 1.0));
  app.add_flag("--covariance-intervals", options.covariance_intervals, "Faster: no profile likelihood");
  CLI::Option* memory = app.add_flag(
      "--memory", options.memory,
      "Instead: the fit with memory and its test on simulated experiments, through sound in every second one, under "
      "conditions drawn at random");
  for (const char* other : {"--samples", "--seeds", "--offset-variance", "--timing", "--covariance-intervals"})
    memory->excludes(app.get_option(other));
  loop::MemoryCalibrationConfig& m = options.with_memory;
  app.add_option("--experiments", m.n_experiments, "With --memory: experiments")
      ->check(within(1, 100000))
      ->needs(memory);
  add_list(app, "--drops", options.drops, "LO,HI", 2, 2, 1.0, 1e4,
           "With --memory: least and largest number of drops, log-uniform between them")
      ->needs(memory);
  app.add_option("--impacts", m.n_impacts, "With --memory: impacts of a drop")->check(within(12, 1000))->needs(memory);
}

Command add_calibrate_command(CLI::App& app) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand("calibrate",
                                         "Calibration of the fit: pulls and coverage on drops of a rough ball drawn "
                                         "from the paper's law, and the Cramer-Rao bound of independent samples");
  command->footer(
      "Examples: bouncelab calibrate --samples 20000 --seeds 500 --timing 8.7e-4\n"
      "          bouncelab calibrate --memory --experiments 200 --out experiments.csv");
  add_calibrate_options(*command, *options);
  command->add_option("--out", options->out, "With --memory: table of the experiments, .csv")
      ->type_name("FILE")
      ->needs(command->get_option("--memory"));
  return {command, [options](Run& run) { return run_calibrate(*options, run); }};
}

}  // namespace bouncelab::cli
