// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/roughness_command.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void add_roughness_options(CLI::App& app, RoughnessOptions& options) {
  app.add_option("--goodness-replicates", options.config.n_goodness,
                 "Replicates of the Anderson-Darling test, 0 = none")
      ->check(within(0, 100000));
}

Command add_roughness_command(CLI::App& app) {
  auto options = std::make_shared<RoughnessOptions>();
  CLI::App* command = app.add_subcommand(
      "roughness",
      "The roughness of a ball from the scatter of its coefficients of restitution: q, and surfaces that scatter so");
  command->footer(
      "Example: bouncelab roughness samples.csv\n"
      "         bouncelab roughness shell.csv --ball table-tennis --out roughness.json");
  command
      ->add_option("samples", options->samples,
                   "Samples of one ball, as restitution writes them: 60 impacts or more, drops of 10 successive ones")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Also the results, .json")->type_name("FILE");
  add_ball_options(*command, options->world, "what the samples say, else a solid ball of the paper's radius");
  add_roughness_options(*command, *options);
  return {command, [options](Run& run) { return run_roughness(*options, run); }};
}

}  // namespace bouncelab::cli
