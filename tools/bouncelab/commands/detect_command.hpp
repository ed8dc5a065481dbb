// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "command.hpp"

namespace bouncelab::cli {

struct DetectOptions {
  std::vector<std::string> recordings;
  std::string out;
  std::string labels;
  int channel = -1;  ///< -1: the one in which impacts are heard best
};

/// The physics options, shared with `loop` and `analyze`.
void add_detect_options(CLI::App& app, DetectOptions& options);
/// What was found in each recording, in the order given; files are read side by side.
std::vector<detection::Detection> detect_all(const DetectOptions& options, const Run& run);
/// One line a recording, for people.
std::string describe(const std::string& recording, const detection::Detection& detection);
/// The same for --json.
Json to_json(const std::string& recording, const detection::Detection& detection);
/// @param keep  where the detections are wanted, besides the files
Outcome run_detect(const DetectOptions& options, Run& run, std::vector<detection::Detection>* keep = nullptr);
Command add_detect_command(CLI::App& app);

}  // namespace bouncelab::cli
