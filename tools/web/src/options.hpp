// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "options/commands.hpp"

namespace bouncelab::web {

/// Reads options of the command line from a JSON object: {"ball": "steel:6mm", "drop_height_m": 0.5, "correct-drag":
/// true}; names as there without the dashes in front, '_' is '-', and a unit at the end may stand (drop_height_m,
/// gravity_mps2). Lists are values with commas.
/// @param sections  with the options that are known; those that every command has are added
/// @return the call, on one thread, outputs replaced without asking
/// @throws InvalidArgument naming the option
cli::Run parse(std::vector<cli::Section> sections, const std::string& json);

}  // namespace bouncelab::web
