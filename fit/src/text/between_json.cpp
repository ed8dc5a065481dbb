// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/fit/between_recordings.hpp"
#include "text/json_values.hpp"

namespace bouncelab::fit {
namespace {

Json json_of(const StandardDeviation& sd) {
  return {{"value", fit::json_of(sd.value)}, {"ci95", fit::json_of(sd.ci95)}};
}

Json json_of(const ChiSquareTest& test) {
  return {{"chi2", fit::json_of(test.chi2)}, {"ndf", test.ndf}, {"p_value", fit::json_of(test.p_value)}};
}

Json json_of(const Drift& drift) {
  return {{"per", drift.by_date ? "day" : "recording"},
          {"slope", fit::json_of(drift.slope)},
          {"p_value", fit::json_of(drift.p_value)},
          {"begin", drift.begin},
          {"end", drift.end},
          {"middle", drift.middle}};
}

Json json_of(const Grouping& grouping) {
  Json rows = Json::array();
  for (const GroupRow& row : grouping.rows)
    rows.push_back(
        {{"name", row.name}, {"n", row.n}, {"offset", fit::json_of(row.offset)}, {"se", fit::json_of(row.se)}});
  return {{"effect", to_string(grouping.effect)},
          {"deviation", grouping.deviation ? json_of(*grouping.deviation) : Json(nullptr)},
          {"rows", rows}};
}

Json date_of(const RecordingOrigin& origin) { return origin.date ? Json(origin.date->day) : Json(nullptr); }

Json rows_of(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings, bool outliers) {
  Json rows = Json::array();
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const RecordingRow& row = between.rows[k];
    const CampaignRecording& recording = recordings[k];
    if (outliers ? !row.is_outlier : recording.summary.status == FitStatus::ok) continue;
    Json json{{"recording", recording.summary.recording},
              {"plate", recording.origin.plate},
              {"day", date_of(recording.origin)},
              {"n", recording.summary.n}};
    if (outliers) {
      json["eps"] = fit::json_of(row.eps);
      json["se"] = fit::json_of(row.se);
      json["offset"] = fit::json_of(row.offset);
      json["standardised"] = fit::json_of(row.standardised);
      json["p_value"] = fit::json_of(row.p_value);
    } else {
      json["status"] = to_string(recording.summary.status);
      json["message"] = recording.summary.message;
    }
    rows.push_back(std::move(json));
  }
  return rows;
}

Json law_of(const BetweenRecordings& between) {
  Json law{{"kind", to_string(between.kind)}};
  Json names = Json::array();
  for (const NamedEstimate& p : between.parameters) names.push_back(p.name);
  law["parameters"] = names;
  for (const NamedEstimate& p : between.parameters) law[p.name] = fit::json_of(p.estimate);
  law["correlation"] = fit::json_of(between.correlation);
  law["nodes"] = nodes_of(between.nodes);
  law["curve"] = curve_of(between.curve);
  for (std::size_t k = 0; k < between.curve_prediction95.size(); ++k)
    law["curve"][k]["prediction95"] = fit::json_of(between.curve_prediction95[k]);
  return law;
}

}  // namespace

std::string to_json(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings, int indent) {
  Json json{{"status", to_string(between.status)}, {"message", between.message}};
  Json sentences = Json::array();
  for (const std::string& sentence : in_words(between, recordings)) sentences.push_back(sentence);
  json["answer"] = sentences;
  json["notes"] = between.notes;
  json["n_recordings"] = between.n_recordings;
  json["n_used"] = between.n_used;
  json["n_samples"] = between.n_samples;
  const bool is_ok = between.status == FitStatus::ok;
  json["v_mps"] = is_ok ? Json(between.v_mps) : Json(nullptr);
  json["eps"] = is_ok ? fit::json_of(between.eps) : Json(nullptr);
  json["prediction95"] = is_ok ? fit::json_of(between.prediction95) : Json(nullptr);
  json["tau"] = is_ok ? json_of(between.tau) : Json(nullptr);
  json["heterogeneity"] = is_ok ? json_of(between.heterogeneity) : Json(nullptr);
  json["shapes"] = is_ok && between.shapes.ndf > 0.0 ? json_of(between.shapes) : Json(nullptr);
  json["drift"] = between.drift ? json_of(*between.drift) : Json(nullptr);
  json["law"] = is_ok ? law_of(between) : Json(nullptr);
  json["plates"] = json_of(between.plates);
  json["days"] = json_of(between.days);
  json["outliers"] = rows_of(between, recordings, true);
  json["not_used"] = rows_of(between, recordings, false);
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string points_json(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings,
                        std::size_t most) {
  constexpr std::size_t kFurthest = 50;
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < recordings.size(); ++k)
    if (between.rows[k].is_used) used.push_back(k);
  const auto far = [&](std::size_t k) { return std::abs(between.rows[k].standardised); };
  std::vector<std::size_t> by_distance = used;
  std::stable_sort(by_distance.begin(), by_distance.end(),
                   [&](std::size_t a, std::size_t b) { return far(a) > far(b); });
  std::vector<bool> is_shown(recordings.size(), false);
  for (std::size_t j = 0; j < by_distance.size(); ++j)
    is_shown[by_distance[j]] = j < kFurthest || between.rows[by_distance[j]].is_outlier;
  const bool by_date = between.drift && between.drift->by_date;
  const auto time = [&](std::size_t k) {
    const auto& date = recordings[k].origin.date;
    return by_date ? (date ? date->day : between.drift->middle) : static_cast<double>(k);
  };
  std::stable_sort(used.begin(), used.end(), [&](std::size_t a, std::size_t b) { return time(a) < time(b); });
  const std::size_t step = most > 0 ? (used.size() + most - 1) / most : 1;
  Json json{{"n", used.size()}};
  for (const char* column :
       {"recording", "plate", "time", "n_samples", "eps", "se", "offset", "standardised", "outlier"})
    json[column] = Json::array();
  for (std::size_t j = 0; j < used.size(); ++j) {
    const std::size_t k = used[j];
    if (!is_shown[k] && j % step != 0) continue;
    const RecordingRow& row = between.rows[k];
    json["recording"].push_back(recordings[k].summary.recording);
    json["plate"].push_back(recordings[k].origin.plate);
    const bool has_date = !by_date || recordings[k].origin.date;
    json["time"].push_back(has_date ? Json(time(k)) : Json(nullptr));
    json["n_samples"].push_back(recordings[k].summary.n);
    const auto short_number = [](double x) { return std::round(x * 1e8) * 1e-8; };  // far below any error
    json["eps"].push_back(short_number(row.eps));
    json["se"].push_back(short_number(row.se));
    json["offset"].push_back(short_number(row.offset));
    json["standardised"].push_back(std::round(row.standardised * 1e3) * 1e-3);
    json["outlier"].push_back(row.is_outlier ? 1 : 0);
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Table to_table(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  const auto texts = [&](auto&& of) {
    std::vector<std::string> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(of(k));
    return values;
  };
  const auto counts = [&](auto&& of) {
    std::vector<std::int64_t> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(static_cast<std::int64_t>(of(k)));
    return values;
  };
  const auto reals = [&](auto&& of) {
    std::vector<double> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(between.rows[k].is_used ? of(k) : kNotKnown);
    return values;
  };
  const auto& rows = between.rows;
  const auto summary = [&](std::size_t k) -> const RecordingSummary& { return recordings[k].summary; };
  const auto date = [&](std::size_t k) {
    const auto& known = recordings[k].origin.date;
    return known ? iso_in_words(*known) : std::string();
  };
  return Table{{{"recording", texts([&](std::size_t k) { return summary(k).recording; })},
                {"plate", texts([&](std::size_t k) { return recordings[k].origin.plate; })},
                {"date", texts(date)},
                {"n", counts([&](std::size_t k) { return summary(k).n; })},
                {"n_drops", counts([&](std::size_t k) { return summary(k).n_drops; })},
                {"n_left_out", counts([&](std::size_t k) { return summary(k).n_left_out; })},
                {"n_outliers", counts([&](std::size_t k) { return summary(k).n_outliers; })},
                {"scatter", reals([&](std::size_t k) { return summary(k).scatter; })},
                {"eps", reals([&](std::size_t k) { return rows[k].eps; })},
                {"sigma_eps", reals([&](std::size_t k) { return rows[k].se; })},
                {"offset", reals([&](std::size_t k) { return rows[k].offset; })},
                {"standardised", reals([&](std::size_t k) { return rows[k].standardised; })},
                {"p_value", reals([&](std::size_t k) { return rows[k].p_value; })},
                {"outlier", counts([&](std::size_t k) { return rows[k].is_outlier; })},
                {"message", texts([&](std::size_t k) { return summary(k).message; })}}};
}

}  // namespace bouncelab::fit
