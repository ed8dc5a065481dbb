// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/loop/closed_loop.hpp"
#include "stages/run.hpp"
#include "stages/simulate.hpp"

namespace bouncelab::stages {

struct LoopOptions {
  std::string preset = "quick";
  std::string out;
  Scene scene;
  bool keep_sound = false;      ///< of the paper's run
  bool without_memory = false;  ///< of the paper's run: without the fits with memory
};

/// Runs the loop and writes what it returned; of lists in the configuration file the loop of every combination, through
/// memory, into sweep.csv, sweep.json and report.html. @throws InvalidArgument saying which combination is wrong
Outcome run_loop(const LoopOptions& options, const Run& run);

/// With the folder and the ball.
std::vector<Section> loop_sections(LoopOptions& options);
/// The paper's run, where the user did not choose otherwise.
void apply_loop_preset(LoopOptions& options, Run& run);

}  // namespace bouncelab::stages
