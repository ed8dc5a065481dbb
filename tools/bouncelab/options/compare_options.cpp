// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/compare_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command add_compare_command(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "Many recordings of one kind of ball: the pooled law, how much they differ, drift, plates, outliers");
  command
      ->add_option("samples", options->samples,
                   "Samples, as restitution writes them, ordered by recording: from 4 recordings on")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Folder for comparison.json, comparison.csv and report.html")
      ->type_name("FOLDER")
      ->required();
  command
      ->add_option("--groups", options->groups,
                   "Table of columns recording, plate, date; without it dates in the recordings' names are taken")
      ->type_name("FILE");
  command->add_option("--title", options->title, "Title of the page");
  command->footer("Example: bouncelab compare samples.csv --groups plates.csv --out out/campaign");
  return {command, [options](Run& run) { return run_compare(*options, run); }};
}

}  // namespace bouncelab::cli
