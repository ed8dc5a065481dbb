// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/loop/detector_score.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "stages/validate.hpp"

namespace bouncelab::stages {

/// A recording and the table of its true times.
struct Case {
  std::string name;
  std::filesystem::path sound, truth;
  loop::Settings settings;  ///< in which it differs from the first one; none of recordings that there are
};

/// To be synthesized in a folder: one recording that differs from the first in nothing, then one for each further value
/// of each list. @throws InvalidArgument naming the recording and the setting
std::vector<Case> cases_of(const ValidateOptions& options, const Run& run, const std::filesystem::path& folder);
/// Simulates and synthesizes them.
void make_sound(const ValidateOptions& options, const std::vector<Case>& cases, const std::filesystem::path& folder,
                const Run& run);
/// Recordings that there are. @throws InvalidArgument, FileError where one has no truth or may have several
std::vector<Case> given_cases(const ValidateOptions& options);

}  // namespace bouncelab::stages
