// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "options/config_file.hpp"

namespace bouncelab::cli {

/// A command line with the options that its --config file adds.
struct CommandLine {
  std::vector<std::string> arguments;  ///< the command's name first
  std::vector<ConfigOption> from_file;
};

/// The line with what its configuration file sets, but for what is typed: the command line wins. Lists to run through
/// stay out of the arguments.
/// @param typed  the command's name first
/// @throws FileError, InvalidArgument naming the line of the file
CommandLine line_with_config(const std::vector<std::string>& typed, const CLI::App& command);

}  // namespace bouncelab::cli
