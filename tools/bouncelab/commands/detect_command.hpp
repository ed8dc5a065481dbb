// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "command.hpp"
#include "json/stage_json.hpp"

namespace bouncelab::cli {

struct DetectOptions {
  std::vector<std::string> recordings;
  std::string list;  ///< file with more recordings, one a line; empty: none
  std::string out;
  std::string labels;
  detection::DetectionConfig config;
};

/// The positional recordings, and --list.
Member recordings_member();
Member list_member();

struct DetectResult {
  std::vector<RecordingResult> recordings;  ///< in the order given; those with the same content once
  /// Everything of the first recordings in which impacts were found, at most kMostDetections, by their index.
  std::map<std::size_t, detection::Detection> first;
};
constexpr std::size_t kMostDetections = 30;

/// The recordings named and those of the list.
/// @throws FileError where the list cannot be read; InvalidArgument where there is no recording
std::vector<std::filesystem::path> recordings_of(const DetectOptions& options);

/// What is kept of one recording.
RecordingResult recording_result(const std::string& recording, const detection::Detection& found);
/// What to tell people of these recordings, a line each.
std::vector<std::string> warnings_of(const std::vector<RecordingResult>& recordings);

/// Writes options.out and, where named, options.labels; neither where no impact was found. A recording with the same
/// content as one before it counts once, and a warning names both.
Stage<DetectResult> run_detect(const DetectOptions& options, const Run& run);

}  // namespace bouncelab::cli
