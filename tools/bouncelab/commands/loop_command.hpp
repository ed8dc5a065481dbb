// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bouncelab/loop/closed_loop.hpp"
#include "command.hpp"
#include "commands/simulate_command.hpp"
#include "commands/synthesize_command.hpp"

namespace bouncelab::cli {

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

/// All that the results depend on: run_identity.
loop::RunIdentity loop_identity(const LoopOptions& options, const Run& run);

/// The journal of an unfinished run in the folder options.out, whose lock the caller has (OutputFolder). Without one,
/// outputs that exist are another run's. None (null) where the run is put together from its parts.
/// @throws FileError where one of `outputs` exists and --force was not given; InvalidArgument where the journal is that
///         of a run with other settings or of another version, or an output is an input
std::unique_ptr<loop::RunJournal> open_journal(const LoopOptions& options, const std::vector<std::string>& outputs,
                                               const Run& run, const loop::RunJournal::OnFinished& on_finished);

/// A run that may replace the files of its own folder.
Run replacing(Run run);

Outcome run_loop(const LoopOptions& options, const Run& run);

}  // namespace bouncelab::cli
