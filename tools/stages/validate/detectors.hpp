// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/loop/detector_score.hpp"
#include "stages/validate/cases.hpp"

namespace bouncelab::stages {

/// Times of any file: numbers one a line are seconds; tables of ours; what convert reads. Nothing, or a title alone, is
/// no time.
/// @param says  a line where it is a table of something else, of how it was read
loop::TrueTimes read_times(const std::filesystem::path& path, std::vector<std::string>& says);

/// Times that were marked: as true ones, and with a standard error where a second number follows on a line.
Onsets read_marks(const std::filesystem::path& path, std::vector<std::string>& says);

/// @throws FileError where a true time is not within the recording; one that cannot be read is left to the detectors
void check_within(const Case& c, const loop::TrueTimes& truth);

/// A detector as it is named by the user, ready to run.
struct Detector {
  std::string name;
  std::filesystem::path program;
  std::vector<std::string> arguments;  ///< with {wav} and {out}
  std::optional<std::string> ending;   ///< of the word with {out}, ".csv" of {out}.csv; absent: it writes no file
  bool has_shell = false;
};
/// @throws InvalidArgument where it cannot be run
Detector detector_of(const std::string& text, bool shell);

/// What one detector marked in one recording.
struct Marks {
  Onsets onsets;
  double processor_s = 0.0;
  std::string failure;  ///< one line; empty: none
  loop::DetectorScore score;
};
/// @param annotated_only  marks before the first and after the last true time do not count
loop::DetectorScore score_of(const loop::TrueTimes& truth, Onsets marked, double duration_s, double processor_s,
                             bool annotated_only);
/// @param folder  absolute, for what is not kept: a detector gets a copy of the recording, since it may overwrite it
Marks marks_of(const Detector& detector, const Case& c, const loop::TrueTimes& truth, const ValidateOptions& options,
               const std::filesystem::path& folder);

}  // namespace bouncelab::stages
