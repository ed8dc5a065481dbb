// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/shards.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <map>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/text.hpp"
#include "campaign/local_run.hpp"
#include "campaign/scripts.hpp"
#include "campaign/slurm.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

fs::path submission_file(const Campaign& campaign) { return campaign.parts_folder() / "submitted.toml"; }

std::int64_t integer_of(const std::string& text) {
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Items in a part: its lines but the first two, which are about the run.
std::int64_t items_in(const fs::path& part) {
  std::ifstream in(part, std::ios::binary);
  std::vector<char> piece(1 << 18);
  std::int64_t n_lines = 0;
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())), in.gcount() > 0)
    n_lines += std::count(piece.begin(), piece.begin() + in.gcount(), '\n');
  return std::max<std::int64_t>(0, n_lines - 2);
}

/// The least of all times where there is no such file.
fs::file_time_type time_of(const fs::path& file) {
  std::error_code missing;
  const auto time = fs::last_write_time(file, missing);
  return missing ? fs::file_time_type::min() : time;
}

/// Is one of the shard's recordings newer than its part?
bool is_changed(const Campaign& campaign, std::int64_t shard, std::int64_t n_shards, const fs::path& part) {
  // a shard that found nothing to do writes its provenance alone
  const auto written = std::max(fs::last_write_time(part), time_of(fs::path(part) += ".meta.json"));
  for (auto k = static_cast<std::size_t>(shard - 1); k < campaign.recordings.size();
       k += static_cast<std::size_t>(n_shards))
    if (time_of(campaign.folder / campaign.recordings[k]) > written) return true;
  return false;
}

/// Was everything merged after the last part was written?
bool is_merged(const Campaign& campaign, std::int64_t n_shards) {
  const auto merged = time_of(campaign.parts_folder() / "merged");
  for (std::int64_t shard = 1; shard <= n_shards; ++shard)
    if (time_of(part_of(campaign, shard, n_shards)) >= merged) return false;
  return true;
}

}  // namespace

std::optional<Submission> read_submission(const Campaign& campaign) {
  if (!fs::exists(submission_file(campaign))) return std::nullopt;
  Submission submission;
  for (const TomlEntry& entry : read_toml_entries(submission_file(campaign)).entries) {
    const std::string value = entry.values.front().front();
    if (entry.key == "on") submission.on_slurm = value == "slurm";
    if (entry.key == "shards") submission.n_shards = integer_of(value);
    if (entry.key == "items") submission.n_items = integer_of(value);
    if (entry.key == "begin_s") submission.begin_s = integer_of(value);
    if (entry.key == "done_before") submission.n_done_before = integer_of(value);
    if (entry.key == "merge") submission.merge = value;
    if (entry.key == "arrays")
      for (const auto& job : entry.values) submission.arrays.push_back(job.front());
  }
  if (submission.n_shards < 1)
    throw FileError(submission_file(campaign).string(),
                    "damaged; delete it, and submit again: complete parts are not done twice");
  return submission;
}

void write_submission(const Campaign& campaign, const Submission& s, bool may_replace) {
  std::string text = fmt::format(
      "# written by bouncelab campaign\non = \"{}\"\nshards = {}\nitems = {}\nbegin_s = {}\ndone_before = {}\n",
      s.on_slurm ? "slurm" : "local", s.n_shards, s.n_items, s.begin_s, s.n_done_before);
  if (!s.arrays.empty()) text += fmt::format("arrays = [{}]\n", fmt::join(s.arrays, ", "));
  if (!s.merge.empty()) text += fmt::format("merge = {}\n", s.merge);
  write_whole(submission_file(campaign), text, may_replace);
}

std::vector<std::int64_t> CampaignState::numbers(ShardState state) const {
  std::vector<std::int64_t> all;
  for (const ShardStatus& shard : shards)
    if (shard.state == state) all.push_back(shard.number);
  return all;
}

bool CampaignState::is_complete() const {
  return std::all_of(shards.begin(), shards.end(),
                     [](const ShardStatus& s) { return s.state == ShardState::complete; });
}

CampaignState state_of(const Campaign& campaign, const Submission& submission, bool with_changes) {
  std::map<std::int64_t, slurm::Queued> queued;
  std::optional<slurm::Queued> merge;
  if (submission.on_slurm)
    for (const slurm::Queued& job : slurm::queue()) {
      if (job.job == submission.merge) merge = job;
      if (std::find(submission.arrays.begin(), submission.arrays.end(), job.job) != submission.arrays.end())
        queued[job.shard] = job;
    }
  const bool is_at_work_here = !submission.on_slurm && is_local_run_at_work(campaign);
  CampaignState state;
  for (std::int64_t number = 1; number <= submission.n_shards; ++number) {
    ShardStatus shard{number, ShardState::failed, 0, false, ""};
    const fs::path part = part_of(campaign, number, submission.n_shards);
    const auto job = queued.find(number);
    if (fs::exists(part)) {
      shard.n_done = items_in(part);
      shard.is_changed = with_changes && is_changed(campaign, number, submission.n_shards, part);
    } else {
      shard.n_done = items_in(fs::path(part).replace_extension(".unfinished"));
    }
    if (job != queued.end()) {
      shard.state = job->second.is_running ? ShardState::running : ShardState::waiting;
      shard.reason = job->second.reason;
    } else if (fs::exists(part)) {
      shard.state = ShardState::complete;
    } else if (is_at_work_here) {
      shard.state = shard.n_done > 0 ? ShardState::running : ShardState::waiting;
    } else {
      shard.reason = last_line(campaign.folder / log_of(campaign, number));
    }
    // an item that was done again has two lines
    const std::int64_t n_own = (submission.n_items - number + submission.n_shards) / submission.n_shards;
    if (submission.n_items > 0) shard.n_done = std::min(shard.n_done, n_own);
    state.n_done += shard.n_done;
    state.shards.push_back(shard);
  }
  if (merge) {
    state.merge = merge->is_running ? ShardState::running : ShardState::waiting;
    state.merge_reason = merge->reason;
  } else if (is_merged(campaign, submission.n_shards)) {
    state.merge = ShardState::complete;
  } else if (is_at_work_here) {
    state.merge = state.is_complete() ? ShardState::running : ShardState::waiting;
  } else {
    state.merge_reason =
        state.is_complete() ? last_line(campaign.folder / merge_log(campaign)) : "not all shards are complete";
  }
  return state;
}

std::string last_line(const fs::path& log) {
  std::ifstream in(log, std::ios::binary | std::ios::ate);
  if (!in) return "no log: it did not begin";
  constexpr std::int64_t kLast_bytes = 1 << 16;
  const std::int64_t size = in.tellg();
  in.seekg(std::max<std::int64_t>(0, size - kLast_bytes));
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  return last.empty() ? "its log is empty" : printable(last, 300);
}

fs::path part_of(const Campaign& campaign, std::int64_t shard, std::int64_t n_shards) {
  return campaign.parts_folder() / fmt::format("shard-{}-of-{}.part", shard, n_shards);
}

const char* word_of(ShardState state) {
  switch (state) {
    case ShardState::complete:
      return "complete";
    case ShardState::running:
      return "running";
    case ShardState::waiting:
      return "waiting";
    case ShardState::failed:
      break;
  }
  return "failed";
}

}  // namespace bouncelab::cli
