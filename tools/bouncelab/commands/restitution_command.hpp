// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/restitution.hpp"
#include "command.hpp"
#include "commands/ball_choice.hpp"

namespace bouncelab::cli {

struct RestitutionOptions {
  std::vector<std::string> onsets;  ///< files
  std::string out;
  fit::RestitutionConfig config;
  BallChoice world;       ///< where a part is not named, that of `config`
  std::string positions;  ///< of the impacts, for the correction of travel times; empty: no correction
  std::vector<double> sensor_m{0.0, 0.0};
};
/// All but the files and the ball.
const Description& members_of(const RestitutionOptions*);

/// What the options describe; reads the positions. @throws InvalidArgument, FileError
fit::RestitutionConfig restitution_config(const RestitutionOptions& options);

std::string text_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);
/// What --json prints.
Object summary_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);

/// The samples are in the file only: there may be more than the memory holds.
Stage<fit::RestitutionCounts> run_restitution(const RestitutionOptions& options, const Run& run);

}  // namespace bouncelab::cli
