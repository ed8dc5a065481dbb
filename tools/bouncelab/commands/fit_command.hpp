// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/fit.hpp"
#include "command.hpp"
#include "commands/ball_choice.hpp"

namespace bouncelab::cli {

struct FitOptions {
  FitOptions() { config.memory = fit::UseMemory::where_long; }

  std::vector<std::string> samples;  ///< files
  std::string out;
  std::string table;  ///< empty: none
  fit::FitConfig config;
  BallChoice world;  ///< in place of what the samples say
};

/// The plain answer, a sentence a line, and an empty line: what the text of run_fit begins with.
std::string answer_text(const fit::FitResult& result);

/// What the options describe.
fit::FitConfig fit_config(const FitOptions& options, const CommonOptions& common);

/// Exit code 1 where the fit did not converge or a constant is not identifiable; what is known is written all the same.
Stage<fit::FitResult> run_fit(const FitOptions& options, const Run& run);
/// Within `loop` and `analyze` the curve is the result: constants that are not identifiable are only a warning there.
Stage<fit::FitResult> as_stage(Stage<fit::FitResult> fitted);

}  // namespace bouncelab::cli
