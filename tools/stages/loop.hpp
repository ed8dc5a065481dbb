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
  BallChoice world = kPaperBall;  ///< of both stages, in place of their own
  SimulateOptions simulate;
  SynthesizeOptions synthesize;
  bool keep_sound = false;      ///< of the paper's run
  bool without_memory = false;  ///< of the paper's run: without the fits with memory
};

/// The loop that the options describe, but for the files that it reads.
/// @param through_memory  a recording for each drop, which has one channel
/// @throws InvalidArgument
loop::LoopConfig loop_config(const LoopOptions& options, const CommonOptions& common, bool through_memory);

/// What the loop reads is there, and nothing that it writes is, unless --force was given. @throws as check_files
void check_loop_files(const LoopOptions& options, const std::vector<std::string>& outputs, const Run& run);

/// Runs the loop and writes what it returned.
Outcome run_loop(const LoopOptions& options, const Run& run);

/// With the folder and the ball.
std::vector<Section> loop_sections(LoopOptions& options);
/// The paper's run, where the user did not choose otherwise.
void apply_loop_preset(LoopOptions& options, Run& run);

}  // namespace bouncelab::stages
