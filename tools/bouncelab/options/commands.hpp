// SPDX-License-Identifier: GPL-3.0-or-later
/// The commands as data: what each is for, its options, and what runs when it is named.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

struct Command {
  std::string name, summary, example;
  std::vector<Section> sections;  ///< their objects live as long as `run`
  std::function<Outcome(Run&)> run;
  std::vector<std::string> stages{};  ///< commands that it runs; a configuration file may have sections of them
  bool runs_through_lists = false;    ///< of a configuration file
  /// Tables that it writes, by heading, for --help: the columns with what they are.
  std::vector<std::pair<std::string, std::vector<Member>>> tables{};
};

struct CommandName {
  std::string name;
  Command (*make)() = nullptr;
  std::string group;  ///< heading in --help
};
/// In the order of --help.
const std::vector<CommandName>& all_commands();
/// nullptr where no command is called so.
inline const CommandName* command_named(const std::vector<CommandName>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const CommandName& c) { return c.name == name; });
  return found == all.end() ? nullptr : &*found;
}

/// Those of the command, and what every command has.
/// @param common  to be set by it
inline std::vector<Section> all_sections(const Command& command, CommonOptions& common) {
  std::vector<Section> sections = command.sections;
  sections.push_back(common_section(common));
  return sections;
}

}  // namespace bouncelab::cli
