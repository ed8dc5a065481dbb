// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/comparison.hpp"

#include <algorithm>
#include <cmath>

namespace bouncelab::report {
using namespace fit;

namespace {

Value date_of(const RecordingOrigin& origin) { return origin.date ? Value(origin.date->day) : Value{}; }

Values outliers_of(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  Values rows;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const RecordingRow& row = between.rows[k];
    if (!row.is_outlier) continue;
    rows.push_back(Object{{"recording", recordings[k].summary.recording},
                          {"plate", recordings[k].origin.plate},
                          {"day", date_of(recordings[k].origin)},
                          {"n", value_of(recordings[k].summary.n)},
                          {"eps", row.eps},
                          {"se", row.se},
                          {"offset", row.offset},
                          {"standardised", row.standardised},
                          {"p_value", row.p_value}});
  }
  return rows;
}

Values not_used_of(const std::vector<CampaignRecording>& recordings) {
  Values rows;
  for (const CampaignRecording& recording : recordings)
    if (recording.summary.status != FitStatus::ok)
      rows.push_back(Object{{"recording", recording.summary.recording},
                            {"plate", recording.origin.plate},
                            {"day", date_of(recording.origin)},
                            {"n", value_of(recording.summary.n)},
                            {"status", to_string(recording.summary.status)},
                            {"message", recording.summary.message}});
  return rows;
}

}  // namespace

Object object_of(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings,
                 const std::optional<GroupDifferences>& differences) {
  Object all{{"status", to_string(between.status)},
             {"message", between.message},
             {"answer", value_of(in_words(between, recordings, differences))}};
  append(all, bouncelab::object_of(between));
  all.emplace_back("differences", value_of(differences));
  all.emplace_back("outliers", outliers_of(between, recordings));
  all.emplace_back("not_used", not_used_of(recordings));
  return all;
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
  std::vector<std::string> names, plates;
  std::vector<double> times, eps, se, offset, standardised;
  std::vector<std::int64_t> n_samples, outlier;
  for (std::size_t j = 0; j < used.size(); ++j) {
    const std::size_t k = used[j];
    if (!is_shown[k] && j % step != 0) continue;
    const RecordingRow& row = between.rows[k];
    names.push_back(recordings[k].summary.recording);
    plates.push_back(recordings[k].origin.plate);
    const bool has_date = !by_date || recordings[k].origin.date;
    times.push_back(has_date ? time(k) : std::nan(""));
    n_samples.push_back(static_cast<std::int64_t>(recordings[k].summary.n));
    const auto short_number = [](double x) { return std::round(x * 1e8) * 1e-8; };  // far below any error
    eps.push_back(short_number(row.eps));
    se.push_back(short_number(row.se));
    offset.push_back(short_number(row.offset));
    standardised.push_back(std::round(row.standardised * 1e3) * 1e-3);
    outlier.push_back(row.is_outlier ? 1 : 0);
  }
  return json_text(Object{{"n", value_of(used.size())},
                          {"recording", names},
                          {"plate", plates},
                          {"time", times},
                          {"n_samples", n_samples},
                          {"eps", eps},
                          {"se", se},
                          {"offset", offset},
                          {"standardised", standardised},
                          {"outlier", outlier}});
}

}  // namespace bouncelab::report
