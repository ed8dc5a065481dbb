// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command.hpp"

namespace bouncelab::cli {

/// The catalogue: balls, materials of balls, plates, each with its source.
Outcome run_balls();

}  // namespace bouncelab::cli
