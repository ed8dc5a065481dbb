// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "command.hpp"
#include "commands/detect_command.hpp"
#include "commands/fit_command.hpp"
#include "commands/restitution_command.hpp"
#include "stage_clock.hpp"

namespace bouncelab::cli {

struct AnalyzeOptions {
  std::string out;
  DetectOptions detect;
  RestitutionOptions restitution;  ///< with the ball, which the fit reads in the samples
  FitOptions fit;
  bool diagnostics = false;  ///< details of each drop in the report
};

Outcome run_analyze(const AnalyzeOptions& options, const Run& run);

/// What follows detection: samples, fit and report of the onsets that lie in the folder options.out.
/// @param detection  of at least one recording with impacts
/// @param clock      of the stages before
Outcome analyze_found(const AnalyzeOptions& options, const Stage<DetectResult>& detection, const Run& run,
                      StageClock& clock);

}  // namespace bouncelab::cli
