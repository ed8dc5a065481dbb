// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "command.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

/// Options start with their defaults known (for the provenance), and the last of several wins. To be called before any
/// option is added.
void set_option_defaults(CLI::App& app);

/// --seed, --threads, --config, --json, --quiet, --force. To be called after all other options were added: numbers of
/// all of them are then read in decimal.
void add_common_options(CLI::App& app, CommonOptions& common);

/// The options that a configuration file may set: all but --help and --config.
std::vector<std::string> config_keys(const CLI::App& app);

/// Every option with the value in force, as given or by default.
Parameters resolved_parameters(const CLI::App& app);

/// Sets the value in force of the parameter with this name.
void set_parameter(Parameters& parameters, const std::string& name, const std::string& value);

}  // namespace bouncelab::cli
