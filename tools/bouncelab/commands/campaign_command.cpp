// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/campaign_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/file_bytes.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "campaign/campaign_file.hpp"
#include "campaign/campaign_text.hpp"
#include "campaign/cost.hpp"
#include "campaign/local_run.hpp"
#include "campaign/scripts.hpp"
#include "campaign/shards.hpp"
#include "campaign/slurm.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

fs::path this_program() { return fs::read_symlink("/proc/self/exe"); }

std::string list_text(const Campaign& campaign) {
  std::string text;
  for (const std::string& recording : campaign.recordings) text += recording + "\n";
  return text;
}

std::string run_toml(const Campaign& campaign) {
  return config_text(campaign, campaign.command_out(),
                     campaign.takes_recordings() ? (campaign.parts() / "recordings.txt").string() : "");
}

/// Recordings, or points of a sweep; 0: not known here.
std::int64_t items_of(const Campaign& campaign) {
  const std::vector<loop::SweepAxis> sweep = check_options(campaign.command, campaign.options, campaign.file.string());
  if (campaign.takes_recordings()) return std::ssize(campaign.recordings);
  return sweep.empty() ? 0 : static_cast<std::int64_t>(loop::n_combinations(sweep));
}

/// What was decided before anything is written.
struct Plan {
  std::int64_t n_items = 0, n_shards = 0;
  std::string measured;  ///< empty: the number of shards was given
};

Plan plan_of(const Campaign& campaign, bool on_slurm) {
  const std::int64_t most = on_slurm ? slurm::most_shards() : std::numeric_limits<std::int32_t>::max();
  Plan plan{items_of(campaign), campaign.jobs.n_shards, ""};
  if (plan.n_shards > most)
    throw InvalidArgument(fmt::format("{}: [jobs] shards = {}: this cluster takes arrays of {} jobs (MaxArraySize)",
                                      campaign.file.string(), plan.n_shards, most));
  if (plan.n_shards > 0) {
    if (plan.n_items > 0) plan.n_shards = std::min(plan.n_shards, plan.n_items);
    return plan;
  }
  if (plan.n_items == 0)
    throw InvalidArgument(campaign.file.string() +
                          ": [jobs] needs shards = N; only recordings and sweeps are measured to choose it");
  const MeasuredCost cost = measure_cost(campaign, this_program(), plan.n_items);
  plan.n_shards = shards_for(campaign.jobs, cost.whole_cpu_s(), plan.n_items, most);
  plan.measured = cost.text;
  return plan;
}

void write_files(const Campaign& campaign, std::int64_t n_shards) {
  const fs::path parts = campaign.parts_folder();
  fs::create_directories(parts / "logs");
  if (campaign.takes_recordings()) {
    write_whole(parts / "recordings.txt", list_text(campaign), true);
    write_whole(parts / "groups.csv", groups_text(campaign), true);
  }
  write_whole(parts / "run.toml", run_toml(campaign), true);
  write_whole(parts / "shard.sh", shard_script(campaign, this_program(), n_shards), true);
  write_whole(parts / "merge.sh", merge_script(campaign, this_program()), true);
}

/// Submits shards and merge; the submission is on disk after each.
/// @param still_queued  an earlier array that the merge has to wait for as well
void submit(const Campaign& campaign, const std::vector<std::int64_t>& shards,
            const std::vector<std::string>& still_queued, Submission& submission) {
  std::string dependency;
  if (!shards.empty()) {
    submission.arrays = still_queued;
    submission.arrays.push_back(slurm::submit(array_arguments(campaign, shards)));
    submission.merge.clear();
    write_submission(campaign, submission, true);
    dependency = "afterok:" + submission.arrays.back();
  }
  // of an earlier array shards may have failed that are submitted again: it has to have ended, and the merge checks
  for (const std::string& array : still_queued) dependency += (dependency.empty() ? "" : ",") + ("afterany:" + array);
  submission.merge = slurm::submit(merge_arguments(campaign, dependency));
  write_submission(campaign, submission, true);
}

/// Runs shards and merge on this machine, and says how it went.
Outcome run_here(const Campaign& campaign, const std::vector<std::int64_t>& shards, const Submission& submission,
                 const Run& run) {
  if (!shards.empty()) run_shards_here(campaign, shards, run);
  if (state_of(campaign, submission).is_complete()) run_merge_here(campaign);
  return status_outcome(campaign, submission, state_of(campaign, submission));
}

std::vector<std::int64_t> all_shards(std::int64_t n) {
  std::vector<std::int64_t> all;
  for (std::int64_t k = 1; k <= n; ++k) all.push_back(k);
  return all;
}

bool is_on_slurm(const Campaign& campaign, const CampaignOptions& options) {
  if (options.on.empty())
    throw InvalidArgument("campaign: --on slurm submits " + campaign.file.string() +
                          " to the cluster, --on local runs it on this machine");
  return options.on == "slurm";
}

Outcome start(const Campaign& campaign, const CampaignOptions& options, const Run& run) {
  const bool on_slurm = is_on_slurm(campaign, options);
  const auto before = read_submission(campaign);
  if (before && !options.dry_run)
    throw FileError(campaign.parts().string(),
                    fmt::format("this campaign was submitted already; bouncelab campaign status {0}, or "
                                "resume {0}; delete the folder to begin anew",
                                shell_word(campaign.file.string())));
  const Plan plan = plan_of(campaign, on_slurm);
  if (options.dry_run)
    return {kDone, "{}", dry_run_text(campaign, this_program(), plan.n_shards, plan.measured, on_slurm), {}, ""};
  write_files(campaign, plan.n_shards);
  Submission submission{on_slurm, plan.n_shards, plan.n_items, std::time(nullptr), 0, {}, ""};
  write_submission(campaign, submission, false);
  if (!on_slurm) return run_here(campaign, all_shards(plan.n_shards), submission, run);
  try {
    submit(campaign, all_shards(plan.n_shards), {}, submission);
  } catch (const FileError&) {
    if (submission.arrays.empty()) fs::remove(campaign.parts_folder() / "submitted.toml");  // nothing was
    throw;
  }
  return submitted_outcome(campaign, submission, all_shards(plan.n_shards), plan.measured);
}

/// The parts have to be of the options that are asked for now.
void check_unchanged(const Campaign& campaign) {
  const fs::path parts = campaign.parts_folder();
  if (whole_content(parts / "run.toml") != run_toml(campaign))
    throw InvalidArgument(
        fmt::format("{}: its options are no longer those in {}; undo the change, or delete {} to begin anew",
                    campaign.file.string(), (campaign.parts() / "run.toml").string(), campaign.parts().string()));
}

/// The recordings that were submitted and are still wanted, in their order, then those that came: a recording stays
/// with its shard as long as none before it goes.
/// @return whether they are others than those submitted
bool take_recordings_in_their_order(Campaign& campaign) {
  std::istringstream submitted(whole_content(campaign.parts_folder() / "recordings.txt"));
  std::set<std::string> wanted(campaign.recordings.begin(), campaign.recordings.end());
  std::vector<std::string> ordered;
  bool is_changed = false;
  for (std::string recording; std::getline(submitted, recording);)
    if (wanted.erase(recording) > 0)
      ordered.push_back(recording);
    else
      is_changed = true;
  is_changed = is_changed || !wanted.empty();
  for (const std::string& recording : campaign.recordings)
    if (wanted.count(recording) > 0) ordered.push_back(recording);
  campaign.recordings = std::move(ordered);
  return is_changed;
}

Outcome resume(Campaign campaign, const CampaignOptions& options, Submission submission, const Run& run) {
  submission.n_items = items_of(campaign);
  check_unchanged(campaign);
  const bool are_others = campaign.takes_recordings() && take_recordings_in_their_order(campaign);
  const CampaignState state = state_of(campaign, submission, true);
  std::vector<std::int64_t> shards;
  std::vector<std::string> queued;
  for (const ShardStatus& shard : state.shards)
    if (shard.state == ShardState::failed || (shard.state == ShardState::complete && (shard.is_changed || are_others)))
      shards.push_back(shard.number);
  const bool some_wait = !state.numbers(ShardState::running).empty() || !state.numbers(ShardState::waiting).empty();
  if (submission.on_slurm && some_wait) queued = submission.arrays;
  if (are_others && some_wait)
    throw InvalidArgument(campaign.file.string() +
                          ": its recordings are others than those submitted, and some shards are at work; wait, or "
                          "campaign cancel first");
  const bool merge_is_queued = state.merge == ShardState::running || state.merge == ShardState::waiting;
  if (shards.empty() && (state.merge == ShardState::complete || merge_is_queued))
    return status_outcome(campaign, submission, state);
  if (!options.on.empty() && (options.on == "slurm") != submission.on_slurm && some_wait)
    throw InvalidArgument(campaign.file.string() + ": some of its shards are at work elsewhere; campaign cancel first");
  if (!options.on.empty()) submission.on_slurm = options.on == "slurm";
  if (options.dry_run)
    return {kDone,
            "{}",
            fmt::format("shards to submit: {}\n", shards.empty() ? "none, only the merge" : ranges(shards)),
            {},
            ""};
  write_files(campaign, submission.n_shards);
  submission.begin_s = std::time(nullptr);
  submission.n_done_before = state.n_done;
  if (!submission.on_slurm) {
    write_submission(campaign, submission, true);
    return run_here(campaign, shards, submission, run);
  }
  if (merge_is_queued) slurm::cancel({submission.merge});
  submit(campaign, shards, queued, submission);
  return submitted_outcome(campaign, submission, shards, "");
}

Outcome cancel(const Campaign& campaign, const Submission& submission) {
  if (!submission.on_slurm)
    return {kDone, "{}", "", {}, "--on local runs in the foreground; Ctrl-C there ends it, and resume continues"};
  std::vector<std::string> jobs;
  for (const slurm::Queued& job : slurm::queue()) {
    const bool is_ours = job.job == submission.merge || std::find(submission.arrays.begin(), submission.arrays.end(),
                                                                  job.job) != submission.arrays.end();
    if (is_ours && std::find(jobs.begin(), jobs.end(), job.job) == jobs.end()) jobs.push_back(job.job);
  }
  slurm::cancel(jobs);
  Outcome outcome;
  outcome.text = jobs.empty()
                     ? "none of its jobs is in the queue\n"
                     : fmt::format("cancelled {} job{}; what is done stays: bouncelab campaign resume {}\n",
                                   jobs.size(), jobs.size() == 1 ? "" : "s", shell_word(campaign.file.string()));
  return outcome;
}

}  // namespace

Outcome run_campaign(const CampaignOptions& options, const Run& run) {
  const Campaign campaign = read_campaign(options.file);
  if (options.action == "start") return start(campaign, options, run);
  const auto submission = read_submission(campaign);
  if (!submission)
    throw FileError(campaign.file.string(),
                    fmt::format("it was not submitted yet; bouncelab campaign {} --on slurm does",
                                shell_word(campaign.file.string())));
  if (options.action == "resume") return resume(campaign, options, *submission, run);
  if (options.action == "cancel") return cancel(campaign, *submission);
  return status_outcome(campaign, *submission, state_of(campaign, *submission));
}

}  // namespace bouncelab::cli
