// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "command.hpp"
#include "commands/detect_command.hpp"
#include "commands/fit_command.hpp"
#include "commands/restitution_command.hpp"

namespace bouncelab::cli {

struct AnalyzeOptions {
  std::string out;
  DetectOptions detect;
  RestitutionOptions restitution;
  FitOptions fit;
  bool diagnostics = false;  ///< details of each drop in the report
};

Outcome run_analyze(const AnalyzeOptions& options, const Run& run);

}  // namespace bouncelab::cli
