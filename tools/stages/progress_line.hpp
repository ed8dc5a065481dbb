// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/core/parallel.hpp"
#include "bouncelab/loop/closed_loop.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// From now on the next progress call after Ctrl-C, SIGTERM or SIGHUP throws Interrupted; a second signal, more than
/// 0.2 s later, ends the program at once. A limit of the size of files, and a pipe that nobody reads, make writing
/// fail.
void notice_signals();

/// A line on standard error with work done, rate and time left, where that is a terminal and --quiet was not given;
/// nothing otherwise; run.on_progress where that is set. Either way the callback throws Interrupted once the user asked
/// to stop.
/// @param label  what is being done ("simulate")
/// @param unit   what is counted ("drops", "s of sound")
ProgressCallback progress_line(const Run& run, const std::string& label, const std::string& unit);

/// The same for the stages of a loop.
loop::StageProgress stage_progress(const Run& run);
/// For the stages of a loop: shows nothing, throws Interrupted once the user asked to stop.
ProgressCallback interrupts_only(const std::string& label, const std::string& unit);

}  // namespace bouncelab::stages
