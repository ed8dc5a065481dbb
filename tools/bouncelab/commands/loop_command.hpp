// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "commands/simulate_command.hpp"
#include "commands/synthesize_command.hpp"

namespace bouncelab::cli {

struct LoopOptions {
  std::string preset = "quick";
  std::string out;
  SimulateOptions simulate;
  SynthesizeOptions synthesize;
  bool keep_sound = false;  ///< of a run through memory
  /// Speeds at which truth and results are compared: slow, middle and fast impacts of a drop from 10 cm.
  std::vector<double> node_speeds_mps{0.25, 0.6, 1.2};
};

/// A command line of `loop` on its own.
struct ParsedLoop {
  LoopOptions options;
  Run run;
};
/// @param arguments  those after the command's name
/// @throws InvalidArgument saying what is wrong with them
ParsedLoop parse_loop(const std::vector<std::string>& arguments);

Outcome run_loop(const LoopOptions& options, Run& run);
Command add_loop_command(CLI::App& app);

}  // namespace bouncelab::cli
