// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/loop/detector_score.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "stages/stages.hpp"

namespace bouncelab::stages {

/// A recording and its true times.
struct Case {
  std::string name;
  std::filesystem::path sound, truth;
  loop::Settings settings;  ///< in which it differs from the first one; none of recordings that there are
  loop::TrueTimes times{};  ///< of the file `truth`, once that is read
};

/// To be synthesized in a folder: one recording that differs from the first in nothing, then one for each further value
/// of each list. @throws InvalidArgument naming the recording and the setting
std::vector<Case> cases_of(const ValidateOptions& options, const Run& run, const std::filesystem::path& folder);
/// Simulates and synthesizes them.
void make_sound(const ValidateOptions& options, const std::vector<Case>& cases, const std::filesystem::path& folder,
                const Run& run);
/// Recordings that there are. @throws InvalidArgument, FileError where one has no truth or may have several
std::vector<Case> given_cases(const ValidateOptions& options);

/// Times of any file: numbers one a line are seconds; tables of ours; what convert reads. Nothing, or a title alone, is
/// no time.
/// @param taken_for  a line where it is a table of something else, of how it was read
loop::TrueTimes read_times(const std::filesystem::path& path, std::vector<std::string>& taken_for);

/// Times that were marked: as true ones, and with a standard error where a second number follows on a line.
Onsets read_marks(const std::filesystem::path& path, std::vector<std::string>& taken_for);

/// @throws FileError where a true time is not within the recording; one that cannot be read is left to the detectors
void check_within(const Case& c);

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
/// @param detector  "builtin", or a command of the shell with {wav} and perhaps {out}
/// @param folder    absolute, for what is not kept: a detector gets a copy of the recording, since it may overwrite it
Marks marks_of(const std::string& detector, const Case& c, const ValidateOptions& options,
               const std::filesystem::path& folder);

}  // namespace bouncelab::stages
