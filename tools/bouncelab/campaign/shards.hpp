// SPDX-License-Identifier: GPL-3.0-or-later
/// How far a campaign is: from its part files, its logs and the queue, nothing else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "campaign/campaign_file.hpp"

namespace bouncelab::cli {

/// What was submitted: OUT.parts/submitted.toml.
struct Submission {
  bool on_slurm = true;
  std::int64_t n_shards = 0;
  std::int64_t n_items = 0;         ///< recordings, points of a sweep; 0: not known
  std::int64_t begin_s = 0;         ///< Unix time of the last submission
  std::int64_t n_done_before = 0;   ///< items that were done at that time
  std::vector<std::string> arrays;  ///< numbers of jobs
  std::string merge;                ///< number of the job
};
std::optional<Submission> read_submission(const Campaign& campaign);
void write_submission(const Campaign& campaign, const Submission& submission, bool may_replace);

enum class ShardState { complete, running, waiting, failed };
const char* word_of(ShardState state);

struct ShardStatus {
  std::int64_t number = 0;  ///< from 1
  ShardState state = ShardState::failed;
  std::int64_t n_done = 0;  ///< items
  bool is_changed = false;  ///< complete, but one of its recordings is newer
  std::string reason;       ///< why it waits; of a failed one the last line of its log
};

struct CampaignState {
  std::vector<ShardStatus> shards;
  ShardState merge = ShardState::failed;
  std::string merge_reason;
  std::int64_t n_done = 0;  ///< items

  std::vector<std::int64_t> numbers(ShardState state) const;
  bool is_complete() const;  ///< all shards
};

/// @param with_changes  also looks at every recording, whether it is newer than its part
/// @throws FileError where the queue cannot be read
CampaignState state_of(const Campaign& campaign, const Submission& submission, bool with_changes = false);

/// The last line of a log that is not empty, printable; where there is none, that.
std::string last_line(const std::filesystem::path& log);

/// Name of the part of a shard.
std::filesystem::path part_of(const Campaign& campaign, std::int64_t shard, std::int64_t n_shards);

}  // namespace bouncelab::cli
