// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command.hpp"
#include "commands/loop_command.hpp"

namespace bouncelab::cli {

/// The paper's experiment at its own size, through memory and through sound.
Outcome run_paper_loop(const LoopOptions& options, const Run& run);

}  // namespace bouncelab::cli
