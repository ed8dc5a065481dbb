// SPDX-License-Identifier: GPL-3.0-or-later
/// The commands as data: what each is for, its options, and what runs when it is named.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// The options of one struct, and the object that they set.
struct Section {
  std::string heading;  ///< in --help; empty: the command's own
  const Description* description = nullptr;
  void* object = nullptr;
  /// Stages whose options these are: the sections of a configuration file in which they may stand too.
  std::vector<std::string> stages{};
  bool only_in_full_help = false;  ///< shown by --help-all alone
};

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
struct SimulateOptions;
struct SynthesizeOptions;
/// What only a simulation of its own has: first drop, preset, states. `preset` is applied by apply_paper_preset.
Section simulation_alone_section(SimulateOptions& options);
Section disturbances_section(SynthesizeOptions& options);
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

/// An option of a command.
struct Option {
  const Member* member = nullptr;
  void* object = nullptr;
  const Section* section = nullptr;
};
std::vector<Option> options_of(const std::vector<Section>& sections);
/// By the name without dashes in front; absent where there is none, or it is positional.
std::optional<Option> option_named(const std::vector<Section>& sections, const std::string& name);

/// Every option with its texts: those typed, else the default as it would be typed.
Parameters parameters_of(const std::vector<Section>& sections, const Given& given);
/// Replaces the value of one of them.
void set_parameter(Parameters& parameters, const std::string& name, const std::string& value);

}  // namespace bouncelab::cli
