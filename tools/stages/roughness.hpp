// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/memory_fit.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

struct RoughnessOptions {
  std::vector<std::string> samples;  ///< files
  std::string out;                   ///< empty: none
  fit::RoughnessConfig config;
  BallChoice world;  ///< in place of what the samples say
};

/// Exit code 1 where the scatter is not that of a rough ball, or there are too few impacts to know.
Outcome run_roughness(const RoughnessOptions& options, const Run& run);

}  // namespace bouncelab::stages
