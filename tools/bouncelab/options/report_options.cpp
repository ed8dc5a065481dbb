// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/report_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command add_report_command(CLI::App& app) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = app.add_subcommand("report", "fit.json and what lies beside it -> one HTML file with pictures");
  command->add_option("folder", options->folder, "Folder that `loop`, `analyze` or `fit` wrote to")->required();
  command->add_option("--out", options->out, "HTML file to write; default FOLDER/report.html")->type_name("FILE");
  command->add_option("--title", options->title, "Title of the page");
  command->footer("Example: bouncelab report out/loop --out report.html");
  return {command, [options](Run& run) { return run_report(*options, run); }};
}

}  // namespace bouncelab::cli
