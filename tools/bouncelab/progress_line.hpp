// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/core/progress.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// From now on Ctrl-C (and SIGTERM) is noticed by the next progress call, which throws Interrupted. A second one kills.
void notice_interrupts();

/// A line on standard error with work done, rate and time left, where that is a terminal and --quiet was not said;
/// nothing otherwise. Either way the callback throws Interrupted once the user asked to stop.
/// @param label  what is being done ("simulate")
/// @param unit   what is counted ("drops", "s of sound")
ProgressCallback progress_line(const Run& run, const std::string& label, const std::string& unit);

}  // namespace bouncelab::cli
