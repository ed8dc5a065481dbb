// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stages/run.hpp"
#include "stages/simulate.hpp"

namespace bouncelab::stages {

struct ValidateOptions {
  std::vector<std::string> detectors;   ///< commands, or builtin
  std::vector<std::string> recordings;  ///< files and folders of sound; empty: synthesized
  std::string truth;                    ///< of the recordings a folder, of the marks a file
  std::string marks;                    ///< times that exist already
  std::string out;
  double time_limit_s = 60.0;  ///< for one recording
  bool offset_only = false;
  bool annotated_only = false;  ///< marks before the first and after the last true time do not count
  Scene scene;                  ///< what is synthesized
};
std::vector<Section> validate_sections(ValidateOptions& options);

/// Scores detectors against true times: those of synthesized recordings, one for each value of each list of the
/// configuration file beside the first, or of recordings that there are; or marks against truth, file against file.
/// Writes scores.csv, validation.json and, in folders, recordings and marks.
/// @throws InvalidArgument, FileError; what a detector does wrong costs the recording only
Outcome run_validate(const ValidateOptions& options, const Run& run);

}  // namespace bouncelab::stages
