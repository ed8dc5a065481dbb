// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "campaign/campaign_file.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// Runs the script of each of these shards on this machine, by xargs, then returns: which of them are complete is seen
/// from the parts. Asked to stop, it asks the shards to.
/// @throws FileError where xargs is not installed, or another run is at work; Interrupted
void run_shards_here(const Campaign& campaign, const std::vector<std::int64_t>& shards, const Run& run);

/// Runs the script of the merge. @return whether it ended well
bool run_merge_here(const Campaign& campaign);

bool is_local_run_at_work(const Campaign& campaign);

}  // namespace bouncelab::cli
