// SPDX-License-Identifier: GPL-3.0-or-later
/// What there is to say of recordings in which impacts were looked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::report {

/// One line on the drops of low odds: how many, and where the first are; none where there is no such drop.
std::vector<std::string> warnings_of_drops(const std::vector<detection::RecordingDetection>& recordings);
/// Why there is no answer where no drop has odds of ten to one; absent where one has, or where there is none.
std::optional<std::string> doubt_of_all_drops(const std::vector<detection::RecordingDetection>& recordings);
/// One line where flights contradict the height that was given, naming both; none else.
std::vector<std::string> warnings_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);
/// What to tell people of each recording, a line each.
std::vector<std::string> warnings_of(const std::vector<detection::RecordingDetection>& recordings);

}  // namespace bouncelab::report
