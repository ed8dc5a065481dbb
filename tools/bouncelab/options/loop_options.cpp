// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/loop.hpp"

namespace bouncelab::cli {

Command loop_command() {
  auto options = std::make_shared<LoopOptions>();
  return {
      "loop",
      "The closed loop: simulate -> synthesize -> detect -> restitution -> fit -> report, all results in one folder",
      "Examples: bouncelab loop --preset quick --out out/loop\n"
      "          bouncelab loop --preset paper --out out/paper\n"
      "          bouncelab loop --config samples/sweep.toml --out out/sweep   (lists in the file are run through)",
      loop_sections(*options),
      [options](Run& run) {
        apply_loop_preset(*options, run);
        return run.sweep.empty() ? run_loop(*options, run) : run_sweep(*options, run);
      },
      {"simulate", "synthesize", "detect", "restitution", "fit", "report"},
      true};
}

}  // namespace bouncelab::cli
