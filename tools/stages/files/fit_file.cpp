// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/fit_file.hpp"

#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"

namespace bouncelab::stages {

bool is_fit(const std::string& content) {
  const auto json = nlohmann::json::parse(content, nullptr, false);
  return json.is_object() && (json.contains("law") || json.contains("hand_off"));
}

void refuse_older_fit(const std::string& content, const std::string& path) {
  if (is_fit(content) && !nlohmann::json::parse(content).contains("scatter"))
    throw FileError(path,
                    "was written by bouncelab 0.2 or before, whose ε was another; make it anew: bouncelab fit "
                    "samples.csv --out fit.json");
}

}  // namespace bouncelab::stages
