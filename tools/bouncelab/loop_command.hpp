// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "command.hpp"
#include "simulate_command.hpp"
#include "synthesize_command.hpp"

namespace bouncelab::cli {

struct LoopOptions {
  std::string preset = "quick";
  std::string out;
  SimulateOptions simulate;
  SynthesizeOptions synthesize;
};

Outcome run_loop(const LoopOptions& options, Run& run);
Command add_loop_command(CLI::App& app);

}  // namespace bouncelab::cli
