// SPDX-License-Identifier: GPL-3.0-or-later
/// What many recordings say together (fit/between_recordings.hpp), in sentences and as JSON.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/fit/between_recordings.hpp"

namespace bouncelab::report {

/// The answer in a few sentences, the most important first. @param recordings  those compared
/// @param differences  of few groups: what they say comes first
std::vector<std::string> in_words(const fit::BetweenRecordings& between,
                                  const std::vector<fit::CampaignRecording>& recordings,
                                  const std::optional<fit::GroupDifferences>& differences = {});

/// comparison.json but for the rows of the recordings, of which it has the outliers and those that could not be used.
Object object_of(const fit::BetweenRecordings& between, const std::vector<fit::CampaignRecording>& recordings,
                 const std::optional<fit::GroupDifferences>& differences = {});

/// What the page draws: columns of the recordings used, in order of time; of more than `most` every so manieth, and
/// always the outliers and the fifty furthest off.
std::string points_json(const fit::BetweenRecordings& between, const std::vector<fit::CampaignRecording>& recordings,
                        std::size_t most = 4000);

}  // namespace bouncelab::report
