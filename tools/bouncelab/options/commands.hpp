// SPDX-License-Identifier: GPL-3.0-or-later
/// The commands as data: what each is for, its options, and what runs when it is named.
#pragma once

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

struct Command {
  std::string name, group;  ///< the group is a heading in --help
  std::string summary, example;
  std::vector<std::string> stages{};  ///< commands that it runs; a configuration file may have sections of them
  bool runs_through_lists = false;    ///< of a configuration file
  /// Tables that it writes, by heading, for --help: the columns with what they are.
  std::vector<std::pair<std::string, std::vector<Member>>> tables{};
  std::vector<Section> sections{};              ///< their objects live as long as `run`
  std::function<void(const Given&)> prepare{};  ///< sets options that were not typed: by a preset, by the input
  std::function<Outcome(Run&)> run{};
};

/// In the order of --help, stages in that of the data; their options have their defaults.
std::vector<Command> all_commands();
/// nullptr where no command is called so.
inline const Command* command_named(const std::vector<Command>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Command& c) { return c.name == name; });
  return found == all.end() ? nullptr : &*found;
}

/// Those of the command, and what every command has.
/// @param common  to be set by it
inline std::vector<Section> all_sections(const Command& command, CommonOptions& common) {
  std::vector<Section> sections = command.sections;
  sections.push_back(common_section(common));
  return sections;
}

/// A command line that is not understood.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sets options from arguments as they are typed: --drops 8, --drops=8, --drag, positional ones.
/// @return what was given
/// @throws WrongUsage  in one line: what is wrong with which option, or which one was probably meant
Given set_options(const std::vector<Section>& sections, const std::vector<std::string>& arguments);

/// What --help of a command shows; all of its options, or the common ones.
std::string help_of(const Command& command, bool all);
/// What --help shows: the commands.
std::string help_of_all();

/// An option that a configuration file sets.
struct ConfigOption {
  std::string name;                 ///< without dashes
  std::string place;                ///< "FILE: line 3"
  std::vector<std::string> values;  ///< one, or several of an option that may be given several times
  bool is_axis = false;             ///< values to run through, one at a time
};

/// The options that a file sets for a command, in its order: those at the top level, in its own section, and in those
/// of the stages that it runs as far as it has their options. The sections of other commands are checked only.
///
/// A key is an option's name without dashes in front; '_' and '-' are the same. Keys stand at the top level or in a
/// section. A list is several values of an option that takes several (height = [0.09, 0.10]), and values to run through
/// of one that takes one (snr_db = [10, 20]); a list of lists runs through the former (height = [[0.05], [0.09,
/// 0.10]]). Integers are decimal.
/// @param text  of the file
/// @param file  its name, for messages
/// @param all   commands whose names sections may have
/// @throws FileError naming the line where the text is no TOML; InvalidArgument naming line and key: an unknown key or
///         section, a key given twice, a list of no use, a value that is none of an option
std::vector<ConfigOption> config_options(std::string_view text, const std::string& file, const Command& command,
                                         const std::vector<Command>& all);

/// A command line with the options that its --config file adds.
struct CommandLine {
  std::vector<std::string> arguments;  ///< the command's name first
  std::vector<ConfigOption> from_file;
};

/// The line with what its configuration file, of at most 1 MB, sets, but for what is typed: the command line wins.
/// Lists to run through stay out of the arguments.
/// @param typed  the command's name first
/// @throws FileError, InvalidArgument naming the line of the file
CommandLine line_with_config(const std::vector<std::string>& typed, const Command& command,
                             const std::vector<Command>& all);

}  // namespace bouncelab::cli
