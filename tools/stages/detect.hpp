// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

struct DetectOptions {
  std::vector<std::string> recordings;
  std::string list;  ///< file with more recordings, one a line; empty: none
  std::string out;
  std::string labels;
  detection::DetectionConfig config;
};

/// The option --drop-height of `restitution`, for the detection: `analyze` sets both by one.
Section drop_height_section(detection::DetectionConfig& config);

using Recordings = std::vector<detection::RecordingDetection>;

/// The recordings named and those of the list.
/// @throws FileError where the list cannot be read; InvalidArgument where there is no recording
std::vector<std::filesystem::path> recordings_of(const DetectOptions& options);

std::vector<std::filesystem::path> readable_of(const Recordings& recordings);
/// What --json prints. @param warnings  that are not of one recording alone
Object summary_of(const Recordings& recordings, const std::vector<Note>& notes);
/// Text, warnings and what went wrong. @param warnings  of the files
Outcome detection_outcome(const Recordings& recordings, std::vector<Note> notes);

/// Writes options.out and, where named, options.labels; neither where no impact was found. A recording with the same
/// content as one before it counts once, and a warning names both.
Outcome run_detect(const DetectOptions& options, const Run& run);

}  // namespace bouncelab::stages
