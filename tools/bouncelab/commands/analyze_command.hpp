// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/loop/analyze.hpp"
#include "stages/detect.hpp"
#include "stages/fit.hpp"
#include "stages/restitution.hpp"
#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

struct AnalyzeOptions {
  std::string out;
  DetectOptions detect;
  RestitutionOptions restitution;  ///< with the ball, which the fit reads in the samples
  FitOptions fit;
  bool diagnostics = false;  ///< details of each drop in the report
};

loop::AnalyzeConfig analyze_config(const AnalyzeOptions& options, const CommonOptions& common);

Outcome run_analyze(const AnalyzeOptions& options, const Run& run);

}  // namespace bouncelab::cli
