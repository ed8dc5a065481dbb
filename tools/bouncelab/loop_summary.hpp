// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/detection/score.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// What one run of the closed loop left behind, as read from its files.
struct LoopResults {
  detection::OnsetScore score;  ///< detected against true times
  std::size_t n_drops = 0;
  std::size_t n_samples = 0;
  RestitutionLaw truth;                                 ///< the law that went in
  Json fit_true;                                        ///< fit.json of the true times
  Json fit_sound;                                       ///< fit.json of the detected times
  std::vector<std::pair<std::string, double>> seconds;  ///< by stage, in order
  std::vector<std::string> warnings;
};

/// summary.json of INTERFACE: what went in beside what came out.
Json loop_summary(const LoopResults& results);

/// The same as a table for people.
std::string loop_table(const Json& summary);

}  // namespace bouncelab::cli
