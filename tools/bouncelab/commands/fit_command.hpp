// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/fit.hpp"
#include "bouncelab/report/answer.hpp"
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

struct Fitted {
  fit::FitResult fit;
  report::FitInWords words;
};

/// The plain answer, a sentence a line, and an empty line: what the text of run_fit begins with.
std::string answer_text(const report::PlainAnswer& answer);

/// What the options describe.
fit::FitConfig fit_config(const FitOptions& options, const CommonOptions& common);

/// Exit code 1 where the fit did not converge or a constant is not identifiable; what is known is written all the same.
Stage<Fitted> run_fit(const FitOptions& options, const Run& run);
/// Within `loop` and `analyze` the curve is the result: constants that are not identifiable are only a warning there.
Stage<Fitted> as_stage(Stage<Fitted> fitted);

}  // namespace bouncelab::cli
