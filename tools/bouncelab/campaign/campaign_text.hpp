// SPDX-License-Identifier: GPL-3.0-or-later
/// What a campaign tells people.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "campaign/campaign_file.hpp"
#include "campaign/shards.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// Both scripts, and the lines that submit them.
std::string dry_run_text(const Campaign& campaign, const std::filesystem::path& program, std::int64_t n_shards,
                         const std::string& measured, bool on_slurm);

Outcome submitted_outcome(const Campaign& campaign, const Submission& submission,
                          const std::vector<std::int64_t>& shards, const std::string& measured);

/// How many shards are where, failed ones with the last line of their logs. Exit code 1 where a shard or the merge has
/// failed.
Outcome status_outcome(const Campaign& campaign, const Submission& submission, const CampaignState& state);

}  // namespace bouncelab::cli
