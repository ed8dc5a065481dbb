// SPDX-License-Identifier: GPL-3.0-or-later
/// Options from TOML files: --config.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "options/commands.hpp"

namespace bouncelab::cli {

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
                                         const std::vector<CommandName>& all);

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
                             const std::vector<CommandName>& all);

}  // namespace bouncelab::cli
