// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages.hpp"

#include <algorithm>
#include <fstream>

#include "bouncelab/core/error.hpp"

namespace bouncelab::cli {

Json read_json(const std::filesystem::path& path) {
  std::ifstream in(path);
  try {
    return Json::parse(in);
  } catch (const Json::parse_error& error) {
    throw FileError(path.string(), std::string("is not JSON: ") + error.what());
  }
}

fit::BudgetConfig budget_of(const sim::SimulationConfig& simulated) {
  fit::BudgetConfig budget;
  budget.ball = simulated.ball;
  budget.gravity_mps2 = simulated.gravity_mps2;
  if (simulated.air) budget.air = *simulated.air;
  budget.drag = simulated.air ? fit::Effect::present : fit::Effect::absent;
  budget.contact_time = budget.travel_time = fit::Effect::absent;
  return budget;
}

void add_warnings(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  for (const std::string& warning : more)
    if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end()) warnings.push_back(warning);
}

}  // namespace bouncelab::cli
