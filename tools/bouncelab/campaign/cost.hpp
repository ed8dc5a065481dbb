// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "campaign/campaign_file.hpp"

namespace bouncelab::cli {

/// What a few items of a campaign cost, and all of them by that.
struct MeasuredCost {
  double cpu_s = 0.0;        ///< of those measured, user and system
  std::int64_t n_items = 0;  ///< measured
  double share = 0.0;        ///< of the whole: of the recordings' bytes, of the number of points
  std::string text;          ///< what was measured, for people

  double whole_cpu_s() const { return share > 0.0 ? cpu_s / share : 0.0; }
};

/// Runs some recordings, or points, one after the other until a second of processor time is used, spread over all: what
/// they cost by size of the file, or by number, is taken for that of the others.
/// @param n_items  of the campaign. @throws FileError, InvalidArgument as the command fails
MeasuredCost measure_cost(const Campaign& campaign, const std::filesystem::path& program, std::int64_t n_items);

/// @param whole_cpu_s  of all items
/// @return 1 ... n_items, at most `most`
std::int64_t shards_for(const JobSettings& jobs, double whole_cpu_s, std::int64_t n_items, std::int64_t most);

}  // namespace bouncelab::cli
