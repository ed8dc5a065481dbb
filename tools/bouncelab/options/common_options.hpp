// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/App.hpp>

#include "command.hpp"

namespace bouncelab::cli {

/// Options start with their defaults known (for the provenance), and the last of several wins. To be called before any
/// option is added.
void set_option_defaults(CLI::App& app);

/// --seed, --threads, --config, --json, --quiet, --force.
void add_common_options(CLI::App& app, CommonOptions& common);

/// Every option with the value in force, as given or by default.
Json resolved_parameters(const CLI::App& app);

}  // namespace bouncelab::cli
