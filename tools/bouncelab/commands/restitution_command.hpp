// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/restitution.hpp"
#include "command.hpp"

namespace bouncelab::cli {

struct RestitutionOptions {
  std::string onsets;
  std::string out;
  fit::RestitutionConfig config;
  double drop_height_m = 0.0;  ///< 0: not known
  std::string positions;       ///< of the impacts, where travel times are to be taken out; empty: they are not
  std::vector<double> sensor_m{0.0, 0.0};
  double wave_speed_mps = 2500.0;
};

/// The physics options, shared with `loop` and `analyze`.
void add_restitution_options(CLI::App& app, RestitutionOptions& options);
/// What was counted, for people: one line.
std::string describe(const fit::RestitutionCounts& counts);
/// The same for --json.
Json to_json(const fit::RestitutionCounts& counts);
Outcome run_restitution(const RestitutionOptions& options, Run& run);
Command add_restitution_command(CLI::App& app);

}  // namespace bouncelab::cli
