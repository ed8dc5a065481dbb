// SPDX-License-Identifier: GPL-3.0-or-later
/// The commands as data: what each is for, its options, and what runs when it is named.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "command.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::cli {

struct Command {
  std::string name, summary, example;
  std::vector<Section> sections;  ///< their objects live as long as `run`
  std::function<Outcome(Run&)> run;
  std::vector<std::string> stages{};  ///< commands that it runs; a configuration file may have sections of them
};

Command simulate_command();
Command synthesize_command();
Command detect_command();
Command convert_command();
Command restitution_command();
Command fit_command();
Command roughness_command();
Command compare_command();
Command report_command();
Command calibrate_command();
Command analyze_command();
Command loop_command();
Command completion_command();
Command balls_command();

struct LoopOptions;
/// With the folder and the ball.
std::vector<Section> loop_sections(LoopOptions& options);

struct CommandName {
  std::string name;
  Command (*make)() = nullptr;
  std::string group;  ///< heading in --help
};
/// In the order of --help.
const std::vector<CommandName>& all_commands();
/// nullptr where no command is called so.
const CommandName* command_named(const std::vector<CommandName>& all, const std::string& name);

/// What every command has.
Section common_section(CommonOptions& common);
/// Those of the command, and what every command has.
/// @param common  to be set by it
std::vector<Section> all_sections(const Command& command, CommonOptions& common);

/// Every option with its texts: those typed, else the default as it would be typed.
Parameters parameters_of(const std::vector<Section>& sections, const Given& given);
/// Replaces the value of one of them.
void set_parameter(Parameters& parameters, const std::string& name, const std::string& value);

}  // namespace bouncelab::cli
