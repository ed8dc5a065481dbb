// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "commands/ball_choice.hpp"
#include "stage_options/synthesize_options.hpp"

namespace bouncelab::cli {

/// Reads options.impacts, writes options.out, the truth, and OUT.others.csv where there are sounds of other things.
Outcome run_synthesize(const SynthesizeOptions& options, const Run& run);

}  // namespace bouncelab::cli
