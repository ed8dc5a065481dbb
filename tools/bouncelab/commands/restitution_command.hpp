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
  std::string positions;       ///< of the impacts, for the correction of travel times; empty: no correction
  std::vector<double> sensor_m{0.0, 0.0};
  double wave_speed_mps = 2500.0;
};

Stage<fit::Restitution> run_restitution(const RestitutionOptions& options, const Run& run);

}  // namespace bouncelab::cli
