// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace bouncelab::cli {

/// The keys of a TOML file as arguments of a command, to be put before those of the command line (which win). A key is
/// an option's name without dashes in front; '_' and '-' are the same. Keys stand at the top level or in a section
/// named like a command whose options this one shares ([simulate], [detect] ...).
/// @throws FileError naming the line: not readable, not TOML; InvalidArgument naming line and key: an unknown key or
///         section, a value of no use
std::vector<std::string> config_arguments(const std::string& path, const CLI::App& command,
                                          const std::vector<std::string>& known_sections);

}  // namespace bouncelab::cli
