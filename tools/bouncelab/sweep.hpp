// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command.hpp"

namespace bouncelab::cli {

/// Runs the closed loop, through memory, for every combination of the values in run.sweep, and tabulates what came out:
/// sweep.csv, sweep.json, report.html in the folder. Killed at any moment, the same command goes on where it was.
Outcome run_sweep(const std::string& folder, Run& run);

}  // namespace bouncelab::cli
