// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command.hpp"
#include "commands/loop_command.hpp"

namespace bouncelab::cli {

/// Runs the closed loop, through memory, for every combination of the values in run.sweep, and tabulates the results:
/// sweep.csv, sweep.json, report.html in the folder.
Outcome run_sweep(const LoopOptions& options, const Run& run);

}  // namespace bouncelab::cli
