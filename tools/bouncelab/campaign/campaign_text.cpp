// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/campaign_text.hpp"

#include <fmt/format.h>

#include <ctime>
#include <fstream>

#include "campaign/scripts.hpp"
#include "json/campaign_json.hpp"
#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace {

constexpr std::size_t kMostShown = 20;  // failed shards; --json has all

std::string clock_text(double seconds) {
  const auto s = static_cast<std::int64_t>(seconds);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string items_name(const Campaign& campaign) { return campaign.takes_recordings() ? "recordings" : "points"; }

/// By the rate since the last submission; negative: not known.
double time_left_s(const Submission& submission, const CampaignState& state) {
  const auto done = static_cast<double>(state.n_done - submission.n_done_before);
  const auto elapsed_s = static_cast<double>(std::time(nullptr) - submission.begin_s);
  if (done <= 0.0 || elapsed_s <= 0.0 || submission.n_items == 0) return -1.0;
  return static_cast<double>(submission.n_items - state.n_done) * elapsed_s / done;
}

std::string counts_text(const CampaignState& state) {
  std::string text;
  for (const ShardState kind : {ShardState::complete, ShardState::running, ShardState::waiting, ShardState::failed})
    if (const auto n = state.numbers(kind).size(); n > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n, word_of(kind));
  return text;
}

/// What the comparison of the recordings warns of: the recordings without samples above all, which cost only
/// themselves.
std::vector<std::string> notes_of_comparison(const Campaign& campaign) {
  std::vector<std::string> notes;
  std::ifstream file(campaign.folder / campaign.out / "compare" / "comparison.json");
  if (!campaign.takes_recordings() || !file) return notes;
  const nlohmann::json comparison = nlohmann::json::parse(file, nullptr, false);
  if (!comparison.is_object() || !comparison.contains("notes")) return notes;
  for (const nlohmann::json& note : comparison["notes"])
    if (note.is_string()) notes.push_back(note.get<std::string>());
  return notes;
}

}  // namespace

std::string dry_run_text(const Campaign& campaign, const std::filesystem::path& program, std::int64_t n_shards,
                         const std::string& measured, bool on_slurm) {
  std::vector<std::int64_t> shards;
  for (std::int64_t k = 1; k <= n_shards; ++k) shards.push_back(k);
  const std::string parts = campaign.parts().string();
  std::string text = measured.empty() ? "" : "# measured: " + measured + "\n";
  text += fmt::format(
      "# {}/shard.sh\n{}\n# {}/merge.sh\n{}\n# {}/run.toml\n{}\n", parts, shard_script(campaign, program, n_shards),
      parts, merge_script(campaign, program), parts,
      config_text(campaign, campaign.command_out(), campaign.takes_recordings() ? parts + "/recordings.txt" : ""));
  std::vector<std::string> submit{on_slurm ? "sbatch" : "xargs"}, merge{on_slurm ? "sbatch" : "bash"};
  const auto append = [](std::vector<std::string>& to, const std::vector<std::string>& more) {
    to.insert(to.end(), more.begin(), more.end());
  };
  append(submit, on_slurm ? array_arguments(campaign, shards) : local_arguments(campaign));
  if (on_slurm)
    append(merge, merge_arguments(campaign, "afterok:ARRAY"));
  else
    merge.push_back((campaign.parts_folder() / "merge.sh").string());
  return text + fmt::format("# {} shards, then the merge:\n{}\n{}\n", n_shards, shell_line(submit), shell_line(merge));
}

Outcome submitted_outcome(const Campaign& campaign, const Submission& submission,
                          const std::vector<std::int64_t>& shards, const std::string& measured) {
  Outcome outcome;
  if (!measured.empty()) outcome.text = measured + "\n";
  if (!shards.empty())
    outcome.text += fmt::format("submitted {} of {} shards as job {}, ", shards.size(), submission.n_shards,
                                submission.arrays.back());
  outcome.text += fmt::format("{}merge as job {}\nscripts and logs are in {}; bouncelab campaign status {}\n",
                              shards.empty() ? "submitted the " : "and their ", submission.merge,
                              campaign.parts().string(), shell_word(campaign.file.string()));
  outcome.json = submitted_json(submission, shards);
  return outcome;
}

Outcome status_outcome(const Campaign& campaign, const Submission& submission, const CampaignState& state) {
  Outcome outcome;
  const double left_s = time_left_s(submission, state);
  outcome.json = status_json(submission, state, left_s);
  outcome.text = fmt::format(
      "{}: {} shards: {}; merge {}{}\n", campaign.out, submission.n_shards, counts_text(state),
      state.merge == ShardState::failed && !state.is_complete() ? "not possible yet" : word_of(state.merge),
      state.merge == ShardState::waiting && state.merge_reason == "DependencyNeverSatisfied" ? " in vain" : "");
  if (submission.n_items > 0) {
    outcome.text += fmt::format("{} of {} {} done", state.n_done, submission.n_items, items_name(campaign));
    if (!state.is_complete() && left_s > 0.0 && state.numbers(ShardState::failed).size() < state.shards.size())
      outcome.text += ", about " + clock_text(left_s) + " left";
    outcome.text += "\n";
  }
  std::size_t n_failed = 0, n_changed = 0;
  std::string first;
  for (const ShardStatus& shard : state.shards) {
    n_changed += shard.is_changed ? 1 : 0;
    if (shard.state != ShardState::failed || ++n_failed > kMostShown) continue;
    outcome.text +=
        fmt::format("shard {} failed: {} ({})\n", shard.number, shard.reason, log_of(campaign, shard.number).string());
  }
  if (n_failed > kMostShown) outcome.text += fmt::format("and {} more; --json lists all\n", n_failed - kMostShown);
  if (n_changed > 0)
    outcome.text += fmt::format("{} complete shards have recordings that are newer than their results\n", n_changed);
  const bool merge_failed = state.is_complete() && state.merge == ShardState::failed;
  if (merge_failed)
    outcome.text += fmt::format("merge failed: {} ({})\n", state.merge_reason, merge_log(campaign).string());
  if (state.merge == ShardState::complete) {
    outcome.text += "the results are in " + campaign.out + "\n";
    outcome.warnings = notes_of_comparison(campaign);
  }
  if (n_failed > 0 || merge_failed) {
    outcome.exit_code = kNotUsable;
    outcome.error =
        fmt::format("{}; bouncelab campaign resume {} does what is missing",
                    merge_failed ? "the merge has failed"
                                 : fmt::format("{} of {} shards have failed", n_failed, submission.n_shards),
                    shell_word(campaign.file.string()));
  }
  return outcome;
}

}  // namespace bouncelab::cli
