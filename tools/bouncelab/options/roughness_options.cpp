// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/roughness_command.hpp"
#include "options/commands.hpp"
#include "options/numbers.hpp"

namespace bouncelab::cli {

Command add_roughness_command(CLI::App& app) {
  auto options = std::make_shared<RoughnessOptions>();
  CLI::App* command = app.add_subcommand(
      "roughness",
      "The roughness of a ball from the scatter of its coefficients of restitution: q, and surfaces that scatter so\n"
      "Example: bouncelab roughness samples.csv\n"
      "         bouncelab roughness shell.csv --inertia-factor 0.667 --out roughness.json");
  command
      ->add_option("samples", options->samples,
                   "Samples of one ball, as restitution writes them: 60 impacts or more, drops of 10 successive ones")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Also the results, .json");
  command
      ->add_option("--inertia-factor", options->config.inertia_factor,
                   "Moment of inertia of the ball over m R^2: 0.4 solid, 0.667 a thin shell")
      ->check(within(1e-3, 1.0));
  command
      ->add_option("--goodness-replicates", options->config.n_goodness,
                   "Replicates of the Anderson-Darling test, 0 = none")
      ->check(within(0, 100000));
  return {command, [options](Run& run) { return run_roughness(*options, run); }};
}

}  // namespace bouncelab::cli
