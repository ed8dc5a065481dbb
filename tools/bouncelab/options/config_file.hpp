// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "options/toml_entries.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

/// What the command at work does with a section of a configuration file.
struct ConfigSection {
  enum class Use {
    own,    ///< of the command itself: all keys are taken
    stage,  ///< of a command that runs as a stage of it: keys are taken, and it is an error where one cannot be
    other,  ///< of a command that does not run: keys are checked only
  };
  Use use = Use::other;
  std::vector<std::string> known;  ///< options of the command that the section is named for
  std::vector<std::string> taken;  ///< of a stage: those that the command at work hands on to it
};

/// The section with this name; absent where no command is called so.
using ConfigSections = std::function<std::optional<ConfigSection>(const std::string& name)>;

/// An option that a configuration file sets.
struct ConfigOption {
  std::string name;                 ///< without dashes
  std::string place;                ///< "FILE: line 3"
  std::vector<std::string> values;  ///< one, or several of an option that may be given several times
  bool is_axis = false;             ///< values to run through, one at a time
};

/// The options that a file sets for a command, in its order.
///
/// A key is an option's name without dashes in front; '_' and '-' are the same. Keys stand at the top level or in a
/// section. A list is several values of an option that takes several (height = [0.09, 0.10]), and values to run through
/// of one that takes one (snr_db = [10, 20]); a list of lists runs through the former (height = [[0.05], [0.09,
/// 0.10]]).
/// @param file  its name, for messages
/// @throws InvalidArgument naming line and key: an unknown key or section, a key given twice, a list of no use
std::vector<ConfigOption> config_options(const TomlEntries& toml, const std::string& file, const CLI::App& command,
                                         const ConfigSections& sections);

}  // namespace bouncelab::cli
