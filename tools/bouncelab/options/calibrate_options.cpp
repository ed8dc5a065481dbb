// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/calibrate_command.hpp"
#include "options/commands.hpp"
#include "options/numbers.hpp"

namespace bouncelab::cli {

Command add_calibrate_command(CLI::App& app) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Calibration of the fit: pulls and coverage on drops of a rough ball drawn from the paper's law, "
      "and the Cramer-Rao bound of independent samples\n"
      "Example: bouncelab calibrate --samples 20000 --seeds 500 --timing 8.7e-4");
  fit::CalibrationConfig& c = options->config;
  command->add_option("--samples", c.n_samples, "Samples per seed")->check(within(100, 100000000));
  command->add_option("--seeds", c.n_seeds, "Seeds")->check(within(2, 1000000));
  command
      ->add_option("--offset-variance", c.offset_variance,
                   "Mean square offset of the contact point over the ball's radius, each component: sets the scatter")
      ->check(within(1e-9, 1e-3));
  command
      ->add_option("--timing", c.sigma_eps_at_1mps,
                   "Timing error of eps at 1 m/s; 8.7e-4 is as wide as the scatter at 0.3 m/s")
      ->check(within(0.0, 1.0));
  command->add_flag("--covariance-intervals", options->covariance_intervals, "Faster: no profile likelihood");
  return {command, [options](Run& run) { return run_calibrate(*options, run); }};
}

}  // namespace bouncelab::cli
