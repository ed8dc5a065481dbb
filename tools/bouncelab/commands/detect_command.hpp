// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "command.hpp"

namespace bouncelab::cli {

struct DetectOptions {
  std::vector<std::string> recordings;
  std::string out;
  std::string labels;
  int channel = -1;  ///< -1: the one in which impacts are detected best
};

/// Writes options.out and, where named, options.labels; neither where no impact was found.
/// @return what was found in each recording, in the order given
Stage<std::vector<detection::Detection>> run_detect(const DetectOptions& options, const Run& run);

}  // namespace bouncelab::cli
