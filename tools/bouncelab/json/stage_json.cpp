// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/stage_json.hpp"

#include <nlohmann/json.hpp>

#include "bouncelab/core/input_file.hpp"
#include "json/ball_json.hpp"
#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const sim::SimulationResult& result) {
  const sim::EnergyLedger& energy = result.energy;
  const auto ended = [&](sim::DropEnd end) { return result.n_ended[static_cast<std::size_t>(end)]; };
  return {{"n_impacts", result.n_impacts},
          {"n_impacts_smooth_sphere", result.n_smooth},
          {"n_drops_ended",
           {{"impacts", ended(sim::DropEnd::impacts_reached)},
            {"speed", ended(sim::DropEnd::speed_reached)},
            {"time", ended(sim::DropEnd::time_reached)},
            {"left_plate", ended(sim::DropEnd::left_plate)}}},
          {"energy_released_j", energy.released_j},
          {"energy_remaining_j", energy.remaining_j},
          {"energy_dissipated_j", energy.dissipated_j},
          {"energy_created_j", energy.created_j},
          {"energy_drag_j", energy.drag_j},
          {"energy_gained_vertical_j", energy.gained_impact_j.vertical_j},
          {"energy_gained_horizontal_j", energy.gained_impact_j.horizontal_j},
          {"energy_gained_rotational_j", energy.gained_impact_j.rotational_j},
          {"energy_closure", energy.closure()},
          {"n_impacts_creating_energy", energy.n_creating}};
}

Json json_of(const synthesis::SynthesisResult& result) {
  return {{"n_impacts", result.n_impacts},
          {"n_other_sounds", result.n_other_sounds},
          {"n_modes", result.n_modes},
          {"n_files", result.n_files},
          {"duration_s", result.duration_s},
          {"noise_rms", result.levels.noise_rms},
          {"weakest_peak", result.levels.weakest_peak},
          {"gain", result.levels.gain}};
}

const char* word(detection::DetectionStatus status) {
  switch (status) {
    case detection::DetectionStatus::ok:
      return "ok";
    case detection::DetectionStatus::too_few_impacts:
      return "too_few_impacts";
    case detection::DetectionStatus::silent:
      return "silent";
    case detection::DetectionStatus::unreadable:
      return "unreadable";
  }
  return "?";
}

Json json_of(const detection::DropSummary& drop) {
  return {{"begin_s", drop.begin_s},
          {"n_impacts", drop.n_impacts},
          {"odds", drop.odds},
          {"probability", drop.probability()},
          {"doubtful", drop.is_doubtful()}};
}

Json json_of(const RecordingResult& r) {
  const detection::RecordingSummary& s = r.summary;
  Json drops = Json::array();
  for (const detection::DropSummary& drop : r.drops) drops.push_back(json_of(drop));
  return {{"recording", input_name(r.recording)},
          {"status", word(r.status)},
          {"message", r.message},
          {"n_onsets", r.n_onsets},
          {"n_drops", s.n_drops},
          {"drops", drops},
          {"n_candidates", s.n_candidates},
          {"format", s.format},
          {"lossy_coding", s.lossy_coding.empty() ? Json(nullptr) : Json(s.lossy_coding)},
          {"ffmpeg", s.ffmpeg.empty() ? Json(nullptr) : Json(s.ffmpeg)},
          {"rate_hz", s.rate_hz},
          {"n_channels", s.n_channels},
          {"channel", s.channel},
          {"channel_reason", s.channel_reason},
          {"duration_s", s.duration_s},
          {"noise_rms", s.noise_rms},
          {"eps_median", s.restitution_median ? Json(*s.restitution_median) : Json(nullptr)},
          {"contact_time_at_1_mps_s", s.contact_time_at_1_mps_s ? Json(*s.contact_time_at_1_mps_s) : Json(nullptr)},
          {"contact_time_sigma_s", s.contact_time_sigma_s ? Json(*s.contact_time_sigma_s) : Json(nullptr)},
          {"warnings", r.warnings}};
}

Json recordings_json(const std::vector<RecordingResult>& recordings) {
  Json all = Json::array();
  for (const RecordingResult& r : recordings) all.push_back(json_of(r));
  return all;
}

Json json_of(const fit::RestitutionCounts& counts) {
  Json breaks = Json::object();
  for (const auto& [reason, n] : counts.breaks) breaks[std::string(name_of(reason))] = n;
  return {{"n_onsets", counts.n_onsets},
          {"n_drops", counts.n_drops},
          {"n_samples", counts.n_samples},
          {"n_flagged", counts.n_flagged},
          {"eps_median", counts.eps_median ? Json(*counts.eps_median) : Json(nullptr)},
          {"breaks", breaks}};
}

Json json_of(const fit::CalibrationResult& result) {
  Json rows = Json::array();
  for (const fit::CalibrationRow& r : result.rows)
    rows.push_back({{"name", r.name},
                    {"truth", r.truth},
                    {"bound_independent", r.bound_independent},
                    {"spread", r.spread},
                    {"mean_se", r.mean_se},
                    {"pull_mean", r.pull_mean},
                    {"pull_sd", r.pull_sd},
                    {"coverage68", r.coverage68},
                    {"coverage95", r.coverage95}});
  return {{"rows", rows}, {"n_failed", result.n_failed}};
}

Json calibration_row_json(const loop::MemoryCalibrationRow& row) {
  Json json{{"quantity", row.quantity}, {"n", row.n}};
  const auto put = [&](const char* name, const std::optional<double>& value) {
    if (value) json[name] = *value;
  };
  put("pull_mean", row.pull_mean);
  put("pull_sd", row.pull_sd);
  put("coverage68", row.coverage68);
  put("coverage95", row.coverage95);
  put("rms_error", row.rms_error);
  put("rms_error_independent", row.rms_error_independent);
  put("gain", row.gain);
  return json;
}

}  // namespace

std::string simulate_json(const sim::SimulationResult& result, const Ball& ball) {
  Json json = json_of(result);
  json["ball"] = ball_json(ball);
  return json_text(json, 2);
}

std::string synthesize_json(const synthesis::SynthesisResult& result, const Ball& ball, const Material& plate) {
  Json json = json_of(result);
  json["ball"] = ball_json(ball);
  json["plate"] = plate_json(plate);
  return json_text(json, 2);
}

std::string detect_json(const std::vector<RecordingResult>& recordings, const std::vector<std::string>& warnings) {
  std::size_t n_onsets = 0;
  for (const RecordingResult& r : recordings) n_onsets += r.n_onsets;
  return json_text(Json{{"n_onsets", n_onsets}, {"recordings", recordings_json(recordings)}, {"warnings", warnings}},
                   2);
}

std::string convert_json(std::size_t n_onsets, std::size_t n_by_hand) {
  return json_text(Json{{"n_onsets", n_onsets}, {"n_by_hand", n_by_hand}}, 2);
}

std::string restitution_json(const fit::RestitutionCounts& counts, const std::optional<Ball>& ball,
                             const std::optional<Material>& plate) {
  Json json = json_of(counts);
  json["ball"] = ball ? ball_json(*ball) : Json(nullptr);
  json["plate"] = plate ? plate_json(*plate) : Json(nullptr);
  return json_text(json, 2);
}

std::string calibrate_json(const fit::CalibrationResult& result) { return json_text(json_of(result), 2); }

std::string report_json(const std::string& report) { return json_text(Json{{"report", report}}, 2); }

std::string analyze_json(const AnalyzeSummary& summary) {
  Json json = json_of(summary.counts);  // counts of onsets, drops and samples, median eps
  json["recordings"] = recordings_json(summary.recordings);
  json["seconds"] = Json::object();
  for (const auto& [stage, seconds] : summary.seconds) json["seconds"][stage] = seconds;
  json["warnings"] = summary.warnings;
  return json_text(json, 2);
}

std::string memory_calibration_json(const std::vector<loop::MemoryCalibrationGroup>& groups) {
  Json all = Json::array();
  for (const loop::MemoryCalibrationGroup& group : groups) {
    Json rows = Json::array();
    for (const loop::MemoryCalibrationRow& row : group.rows) rows.push_back(calibration_row_json(row));
    all.push_back({{"family", group.family},
                   {"name", group.name},
                   {"n", group.n},
                   {"n_failed", group.n_failed},
                   {"n_holds", group.n_holds},
                   {"rows", rows}});
  }
  return json_text(Json{{"n_experiments", groups.front().n}, {"n_failed", groups.front().n_failed}, {"groups", all}},
                   2);
}

nlohmann::ordered_json scatter_json(const loop::ScatterTheory& theory) {
  Json slopes = Json::array();
  for (const loop::ExpectedSlopes& s : theory.slopes)
    slopes.push_back({{"v_mps", s.v_mps}, {"n", s.n}, {"rising", s.rising}, {"falling", s.falling}});
  Json densities = Json::array();
  for (const loop::ExpectedDensity& d : theory.densities)
    densities.push_back({{"v_mps", d.v_mps},
                         {"eps", d.eps},
                         {"density", d.density},
                         {"n_simulated", d.n_simulated},
                         {"simulated_counts", d.simulated_counts}});
  return {{"q", theory.q},
          {"contact_factor", theory.contact_factor},
          {"offset_variance", theory.offset_variance},
          {"slopes", slopes},
          {"densities", densities},
          {"n_transforms", theory.n_transforms},
          {"transform_counts", theory.transform_counts}};
}

}  // namespace bouncelab::cli
