// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/loop_json.hpp"

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "bouncelab/core/elementary.hpp"
#include "json/json_text.hpp"
#include "json/stage_json.hpp"

namespace bouncelab::cli {
namespace {

using Json = nlohmann::ordered_json;

Json known(const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); }

/// {value, se} as far as they are known.
Json value_and_error(const std::optional<fit::Estimate>& estimate, const char* value_name = "value") {
  Json json = Json::object();
  if (!estimate) return json;
  if (std::isfinite(estimate->value)) json[value_name] = estimate->value;
  if (estimate->se && std::isfinite(*estimate->se)) json["se"] = *estimate->se;
  return json;
}

Json object_of(const SecondsByStage& seconds) {
  Json json = Json::object();
  for (const auto& [stage, s] : seconds) json[stage] = s;
  return json;
}

void add_score(const detection::OnsetScore& score, Json& summary) {
  summary["n_impacts"] = score.n_true;
  summary["n_found"] = score.n_found;
  summary["n_missed"] = score.n_missed;
  summary["n_invented"] = score.n_invented;
  if (score.rms_s) summary["time_rms_s"] = *score.rms_s;
  if (score.rms_within_drops_s) summary["time_rms_within_drops_s"] = *score.rms_within_drops_s;
  if (score.offset_s) summary["time_offset_s"] = *score.offset_s;
  if (score.pull_sd) summary["time_pull_sd"] = *score.pull_sd;
}

Json constants_of(const loop::LoopScore& score) {
  Json constants = Json::array();
  for (const loop::ComparedConstant& c : score.constants) {
    Json constant{{"name", c.name},
                  {"from_true_times", value_and_error(c.value.from_true_times)},
                  {"from_sound", value_and_error(c.value.from_sound)}};
    if (c.truth) constant["truth"] = *c.truth;
    constants.push_back(std::move(constant));
  }
  return constants;
}

Json slopes_of(const loop::LoopScore& score) {
  Json slopes = Json::array();
  for (const loop::ComparedSlopes& s : score.slopes)
    slopes.push_back(
        {{"v_mps", s.v_mps},
         {"from_true_times",
          {{"rising", value_and_error(s.rising.from_true_times)},
           {"falling", value_and_error(s.falling.from_true_times)}}},
         {"from_sound",
          {{"rising", value_and_error(s.rising.from_sound)}, {"falling", value_and_error(s.falling.from_sound)}}}});
  return slopes;
}

Json json_of(const fit::Estimate& estimate) {
  Json json{{"value", estimate.value}};
  if (estimate.se) json["se"] = *estimate.se;
  if (estimate.ci95) json["ci95"] = {estimate.ci95->lo, estimate.ci95->hi};
  return json;
}

Json json_of(const report::Conclusion& c) {
  Json json{
      {"claim", c.claim}, {"measure", c.measure}, {"criterion", c.criterion}, {"holds", c.holds}, {"detail", c.detail}};
  json["value"] = known(c.value);
  json["ci95"] = c.ci95 ? Json{c.ci95->lo, c.ci95->hi} : Json(nullptr);
  return json;
}

Json json_of(const loop::SlopePair& pair) {
  return {{"simulation", json_of(pair.simulation)}, {"sound", json_of(pair.sound)}, {"ratio", pair.ratio}};
}

Json spread_of(const fit::FitResult& fit) {
  Json spread{{"v_mps", Json::array()}, {"spread", Json::array()}};
  for (const fit::BudgetRow& row : fit.budget.rows) {
    spread["v_mps"].push_back(row.v_mps);
    spread["spread"].push_back(row.spread);
  }
  spread["exponent"] = fit.budget.width_exponent ? json_of(*fit.budget.width_exponent) : Json(nullptr);
  return spread;
}

Json json_of(const std::vector<sim::EnergyShares>& shares) {
  Json json;
  const auto column = [&](const char* name, auto member) {
    for (const sim::EnergyShares& s : shares) json[name].push_back(s.*member);
  };
  column("impact", &sim::EnergyShares::impact);
  column("n", &sim::EnergyShares::n);
  column("vertical", &sim::EnergyShares::vertical);
  column("horizontal", &sim::EnergyShares::horizontal);
  column("rotational", &sim::EnergyShares::rotational);
  column("rotational_lo", &sim::EnergyShares::rotational_lo);
  column("rotational_hi", &sim::EnergyShares::rotational_hi);
  return json;
}

Json json_of(const loop::ReservoirCheck& check) {
  Json drops;
  for (const loop::ReservoirOfDrop& d : check.drops) {
    drops["drop"].push_back(d.drop);
    drops["first_impact"].push_back(d.first_impact);
    drops["last_impact"].push_back(d.last_impact);
    drops["simulated_m2ps2"].push_back(d.simulated_m2ps2);
    drops["sound_m2ps2"].push_back(d.sound.gain_m2ps2);
    drops["own_se_m2ps2"].push_back(hypot(d.sound.timing_se_m2ps2, d.sound.offset_se_m2ps2));
    drops["law_se_m2ps2"].push_back(known(d.sound.law_se_m2ps2));
  }
  return {{"law", check.with_memory ? "memory" : "independent"},
          {"n_drops", check.drops.size()},
          {"correlation", check.correlation},
          {"rms_simulated_m2ps2", check.rms_simulated_m2ps2},
          {"mean_difference_m2ps2", check.mean_difference_m2ps2},
          {"rms_difference_m2ps2", check.rms_difference_m2ps2},
          {"expected_law_m2ps2", known(check.expected_law_m2ps2)},
          {"expected_timing_m2ps2", check.expected_timing_m2ps2},
          {"expected_offset_m2ps2", check.expected_offset_m2ps2},
          {"spin_share", check.spin_share},
          {"drops", drops}};
}

Json json_of(const sim::BallSection& ball) {
  Json section{{"half_angle_rad", ball.half_angle_rad}, {"angle_rad", Json::array()}, {"radius_m", Json::array()}};
  for (const sim::SectionCircle& circle : ball.circles) {
    section["angle_rad"].push_back(circle.angle_rad);
    section["radius_m"].push_back(circle.radius_m);
  }
  return {{"radius_m", ball.ball_radius_m},
          {"n_asperities", ball.n_asperities},
          {"mean_asperity_radius_m", ball.mean_asperity_radius_m},
          {"section", section}};
}

Json json_of(const loop::SweepPoint& point) {
  Json json{{"settings", Json::object()}, {"values", Json::object()}};
  for (const auto& [option, value] : point.settings) json["settings"][option] = value;
  for (const loop::SweepValue& v : point.values)
    json["values"][v.name] = v.is_count && v.value ? Json(static_cast<std::uint64_t>(*v.value)) : known(v.value);
  json["trouble"] = point.failure;
  return json;
}

}  // namespace

std::string loop_summary_json(const loop::LoopScore& score, const SecondsByStage& seconds,
                              const std::vector<std::string>& warnings,
                              const std::optional<loop::ScatterTheory>& theory,
                              const std::optional<loop::ReservoirCheck>& reservoir, const sim::BallSection& ball,
                              const std::optional<LoopWork>& work) {
  Json summary;
  summary["n_drops"] = score.n_drops;
  add_score(score.onsets, summary);
  summary["n_samples"] = score.n_samples;
  summary["eps_nodes"] = Json::array();
  for (const loop::ComparedNode& node : score.nodes) {
    summary["eps_nodes"].push_back({{"v_mps", node.v_mps},
                                    {"truth", node.truth},
                                    {"from_true_times", value_and_error(node.eps.from_true_times, "eps")},
                                    {"from_sound", value_and_error(node.eps.from_sound, "eps")}});
    const loop::Compared& memory = node.eps_with_memory;
    if (!memory.from_sound && !memory.from_true_times) continue;
    summary["eps_nodes"].back()["from_true_times_with_memory"] = value_and_error(memory.from_true_times, "eps");
    summary["eps_nodes"].back()["from_sound_with_memory"] = value_and_error(memory.from_sound, "eps");
  }
  summary["constants"] = constants_of(score);
  summary["slopes"] = slopes_of(score);
  summary["truth_curve"] = Json::array();
  for (const loop::LawPoint& point : score.truth_curve)
    summary["truth_curve"].push_back({{"v_mps", point.v_mps}, {"eps", point.eps}});
  if (theory) summary["theory"] = scatter_json(*theory);
  if (reservoir) summary["reservoir"] = json_of(*reservoir);
  if (ball.n_asperities > 0) summary["ball"] = json_of(ball);
  summary["seconds"] = object_of(work ? work->wall_s : seconds);
  summary["warnings"] = warnings;
  if (work) {
    summary["sound_s"] = work->sound_s;
    summary["processor_seconds"] = object_of(work->processor_s);
    summary["peak_memory_bytes"] = work->peak_memory_bytes;
  }
  return json_text(summary, 2);
}

std::string paper_json(const loop::LoopResult& loop, const std::vector<loop::SlopeWindow>& windows,
                       const std::vector<report::Conclusion>& drawn) {
  Json conclusions = Json::array(), slopes = Json::array();
  for (const report::Conclusion& c : drawn) conclusions.push_back(json_of(c));
  for (const loop::SlopeWindow& w : windows)
    slopes.push_back({{"v_mps", w.v_mps},
                      {"n_simulation", w.n_simulation},
                      {"n_sound", w.n_sound},
                      {"rising", json_of(w.rising)},
                      {"falling", json_of(w.falling)}});
  return Json{{"conclusions", conclusions},
              {"slopes", slopes},
              {"spread",
               {{"simulation", spread_of(loop.direct)},
                {"sound", spread_of(loop.sound)},
                {"smooth_ball", spread_of(loop.smooth_sound)}}},
              {"smooth_ball",
               {{"n_drops", loop.smooth.drops.size()},
                {"n_impacts", loop.smooth.score.n_true},
                {"n_missed", loop.smooth.score.n_missed},
                {"n_invented", loop.smooth.score.n_invented}}},
              {"energy_shares", json_of(loop.shares)}}
      .dump(1);
}

std::string sweep_json(const std::vector<loop::SweepAxis>& axes, const std::vector<loop::SweepPoint>& points,
                       int indent) {
  Json sweep{{"lists", Json::object()}, {"points", Json::array()}};
  for (const loop::SweepAxis& axis : axes) sweep["lists"][axis.option] = axis.values;
  for (const loop::SweepPoint& point : points) sweep["points"].push_back(json_of(point));
  return json_text(sweep, indent);
}

}  // namespace bouncelab::cli
