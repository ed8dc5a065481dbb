// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "command.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

/// Options start with their defaults known (for the provenance), and the last of several wins. To be called before any
/// option is added.
void set_option_defaults(CLI::App& app);

/// --seed, --threads, --config, --json, --quiet, --force.
void add_common_options(CLI::App& app, CommonOptions& common);

/// Every option with the value in force, as given or by default.
Parameters resolved_parameters(const CLI::App& app);

/// Sets the value in force of the parameter with this name.
void set_parameter(Parameters& parameters, const std::string& name, const std::string& value);

}  // namespace bouncelab::cli
