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
  bool diagnostics = false;  ///< a look inside each drop, in the report
};

Outcome run_analyze(const AnalyzeOptions& options, Run& run);
Command add_analyze_command(CLI::App& app);

}  // namespace bouncelab::cli
