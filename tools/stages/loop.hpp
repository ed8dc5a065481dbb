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
  bool keep_sound = false;      ///< of a run through memory
  bool without_memory = false;  ///< of a run through memory: without the fits with memory
};

/// The loop through memory that the options describe. @throws InvalidArgument
loop::LoopConfig loop_config(const LoopOptions& options, const CommonOptions& common);

/// What the loop reads is there, and nothing that it writes is, unless --force was given. @throws as check_files
void check_loop_files(const LoopOptions& options, const std::vector<std::string>& outputs, const Run& run);

/// Through files, or with the preset `paper` through memory.
Outcome run_loop(const LoopOptions& options, const Run& run);
/// The paper's experiment at its own size, through memory and through sound.
Outcome run_paper_loop(const LoopOptions& options, const Run& run);

/// With the folder and the ball.
std::vector<Section> loop_sections(LoopOptions& options);
/// The paper's run, where the user did not choose otherwise.
void apply_loop_preset(LoopOptions& options, Run& run);

}  // namespace bouncelab::stages
