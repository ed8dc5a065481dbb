// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "commands/balls_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command add_balls_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "balls", "Lists the balls, materials and plates that --ball and --plate know, with their numbers and sources");
  command->footer("Example: bouncelab balls --json");
  return {command, [](Run&) { return run_balls(); }};
}

}  // namespace bouncelab::cli
