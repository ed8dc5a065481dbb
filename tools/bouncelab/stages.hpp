// SPDX-License-Identifier: GPL-3.0-or-later
/// What `loop` and `analyze` share: running stages on the files of one folder.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/fit/error_budget.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// Wall time of each stage, in order.
class StageClock {
 public:
  /// Runs one stage and books its time under `name`.
  template <class Stage>
  auto time(const std::string& name, Stage&& stage) {
    const auto start = std::chrono::steady_clock::now();
    auto result = stage();
    book(name, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return result;
  }
  const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; }

 private:
  void book(const std::string& name, double seconds) {
    for (auto& [stage, sum] : seconds_)
      if (stage == name) {
        sum += seconds;
        return;
      }
    seconds_.emplace_back(name, seconds);
  }
  std::vector<std::pair<std::string, double>> seconds_;
};

/// A JSON file of an earlier stage. @throws FileError
Json read_json(const std::filesystem::path& path);

/// What is in the samples of a simulated ball: it strikes without delay and, in sound, always at one point.
fit::BudgetConfig budget_of(const sim::SimulationConfig& simulated);

/// Appends what is not there yet.
void add_warnings(std::vector<std::string>& warnings, const std::vector<std::string>& more);

}  // namespace bouncelab::cli
