// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/memory_fit.hpp"

namespace bouncelab::fit {

/// fit.json: everything of a FitResult, numbers with 17 digits, null where a value is not known.
/// @param indent  spaces for each level
std::string to_json(const FitResult& result, int indent = 1);

/// What the command `roughness` writes, in the same manner.
std::string to_json(const RoughnessResult& result, int indent = 1);

}  // namespace bouncelab::fit
