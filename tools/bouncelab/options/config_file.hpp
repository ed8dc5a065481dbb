// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/loop/settings.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

/// The content of a TOML file of options.
struct ConfigArguments {
  std::vector<std::string> arguments;  ///< to be put before those of the command line, which win
  std::vector<loop::SweepAxis> lists;  ///< lists for options that take one value: to be run through
};

/// A key is an option's name without dashes in front; '_' and '-' are the same. Keys stand at the top level or in a
/// section named like a command whose options this one shares ([simulate], [detect] ...). A list is several values of
/// an option that takes several (height = [0.09, 0.10]), and values to run through of one that takes one
/// (snr_db = [10, 20]); a list of lists runs through the former (height = [[0.05], [0.09, 0.10]]).
/// @throws FileError naming the line: not readable, not TOML; InvalidArgument naming line and key: an unknown key or
///         section, a value of no use
ConfigArguments config_arguments(const std::string& path, const CLI::App& command,
                                 const std::vector<std::string>& known_sections);

}  // namespace bouncelab::cli
