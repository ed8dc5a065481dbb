// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "campaign/shards.hpp"

namespace bouncelab::cli {

/// Numbers of jobs and shards.
std::string submitted_json(const Submission& submission, const std::vector<std::int64_t>& shards);

/// Every shard with its state. @param time_left_s  negative: not known
std::string status_json(const Submission& submission, const CampaignState& state, double time_left_s);

}  // namespace bouncelab::cli
