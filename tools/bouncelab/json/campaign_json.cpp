// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/campaign_json.hpp"

#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace {

nlohmann::ordered_json jobs_of(const Submission& submission) {
  return {
      {"on", submission.on_slurm ? "slurm" : "local"}, {"arrays", submission.arrays}, {"merge_job", submission.merge}};
}

}  // namespace

std::string submitted_json(const Submission& submission, const std::vector<std::int64_t>& shards) {
  nlohmann::ordered_json json = jobs_of(submission);
  json["n_shards"] = submission.n_shards;
  json["submitted"] = shards;
  return json_text(json, 2);
}

std::string status_json(const Submission& submission, const CampaignState& state, double time_left_s) {
  nlohmann::ordered_json json = jobs_of(submission);
  json["n_shards"] = submission.n_shards;
  json["n_items"] = submission.n_items;
  json["n_done"] = state.n_done;
  if (time_left_s >= 0.0) json["time_left_s"] = time_left_s;
  json["merge"] = word_of(state.merge);
  if (!state.merge_reason.empty()) json["merge_reason"] = state.merge_reason;
  json["shards"] = nlohmann::ordered_json::array();
  for (const ShardStatus& shard : state.shards) {
    nlohmann::ordered_json one{{"shard", shard.number}, {"state", word_of(shard.state)}, {"n_done", shard.n_done}};
    if (shard.is_changed) one["changed"] = true;
    if (!shard.reason.empty()) one["reason"] = shard.reason;
    json["shards"].push_back(std::move(one));
  }
  return json_text(json, 2);
}

}  // namespace bouncelab::cli
