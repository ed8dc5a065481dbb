// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command.hpp"
#include "commands/loop_command.hpp"

namespace bouncelab::cli {

/// The paper's experiment at its own size, through memory and through sound. Killed at any moment, the same command
/// continues where it was and ends with the same results.
Outcome run_paper_loop(const LoopOptions& options, const Run& run);

}  // namespace bouncelab::cli
