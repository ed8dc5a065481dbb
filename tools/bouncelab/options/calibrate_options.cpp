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
      "Examples: bouncelab calibrate --samples 20000 --seeds 500 --timing 8.7e-4\n"
      "          bouncelab calibrate --memory --experiments 200 --out experiments.csv");
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
  CLI::Option* memory = command->add_flag(
      "--memory", options->memory,
      "Instead: the fit with memory and its test on simulated experiments, through sound in every second one, under "
      "conditions drawn at random");
  for (const char* other : {"--samples", "--seeds", "--offset-variance", "--timing", "--covariance-intervals"})
    memory->excludes(command->get_option(other));
  loop::MemoryCalibrationConfig& m = options->with_memory;
  command->add_option("--experiments", m.n_experiments, "With --memory: experiments")
      ->check(within(1, 100000))
      ->needs(memory);
  add_list(*command, "--drops", options->drops, "LO,HI", 2, 2, 1.0, 1e4,
           "With --memory: least and largest number of drops, log-uniform between them")
      ->needs(memory);
  command->add_option("--impacts", m.n_impacts, "With --memory: impacts of a drop")
      ->check(within(12, 1000))
      ->needs(memory);
  command->add_option("--out", options->out, "With --memory: table of the experiments, .csv")->needs(memory);
  return {command, [options](Run& run) { return run_calibrate(*options, run); }};
}

}  // namespace bouncelab::cli
