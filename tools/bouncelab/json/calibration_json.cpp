// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/calibration_json.hpp"

#include <nlohmann/json.hpp>
#include <optional>

#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace bouncelab::cli
