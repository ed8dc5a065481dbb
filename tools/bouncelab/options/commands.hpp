// SPDX-License-Identifier: GPL-3.0-or-later
/// Registration of the commands: each adds its options to the parser and says what runs when it was named.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "options/config_file.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

/// A command as main knows it.
struct Command {
  CLI::App* app = nullptr;
  std::function<Outcome(Run&)> run;
};

Command add_simulate_command(CLI::App& app);
Command add_synthesize_command(CLI::App& app);
Command add_detect_command(CLI::App& app);
Command add_convert_command(CLI::App& app);
Command add_restitution_command(CLI::App& app);
Command add_fit_command(CLI::App& app);
Command add_roughness_command(CLI::App& app);
Command add_compare_command(CLI::App& app);
Command add_report_command(CLI::App& app);
Command add_calibrate_command(CLI::App& app);
Command add_analyze_command(CLI::App& app);
Command add_loop_command(CLI::App& app);
Command add_completion_command(CLI::App& app);
Command add_balls_command(CLI::App& app);

struct CommandName {
  std::string name;
  Command (*add)(CLI::App&) = nullptr;
  std::string group;  ///< heading in --help
};
const std::vector<CommandName>& all_commands();

/// What `command` does with a section of its configuration file: it takes its own, and those of the commands that it
/// runs as stages as far as it has their options. Absent where no command is called like the section.
std::optional<ConfigSection> config_section(const std::string& command, const std::string& section);

}  // namespace bouncelab::cli
