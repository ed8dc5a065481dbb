// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/restitution.hpp"
#include "stage_options/ball_choice.hpp"
#include "stage_options/foreign_options.hpp"

namespace bouncelab::options {

struct RestitutionOptions {
  std::vector<std::string> onsets;  ///< files
  std::string out;
  ForeignFileOptions foreign;  ///< of onsets that this program did not write
  fit::RestitutionConfig config;
  BallChoice world;       ///< where a part is not named, that of `config`
  std::string positions;  ///< of the impacts, for the correction of travel times; empty: no correction
  std::vector<double> sensor_m{0.0, 0.0};
};
/// All but the files, what they are, the ball, and what `config` has.
Description members_of(const RestitutionOptions*);

/// With the ball and the plate that were chosen; positions are not read.
fit::RestitutionConfig with_ball(const RestitutionOptions& options);

}  // namespace bouncelab::options
