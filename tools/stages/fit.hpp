// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/fit.hpp"
#include "bouncelab/report/answer.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

struct FitOptions {
  FitOptions() { config.memory = fit::UseMemory::where_long; }

  std::vector<std::string> samples;  ///< files
  std::string out;
  std::string table;       ///< empty: none
  std::string histograms;  ///< likewise
  std::string columns;     ///< of a table that this program did not write: "v=speed,eps=e"
  fit::FitConfig config;
  BallChoice world;  ///< in place of what the samples say
};

/// The plain answer, a sentence a line, and an empty line: what the text of run_fit begins with.
std::string answer_text(const report::PlainAnswer& answer);

/// What the options describe.
fit::FitConfig fit_config(const FitOptions& options, const CommonOptions& common);

/// Text and warnings; exit code 1 where there is no curve. Constants that are not identifiable are a warning, the last.
/// @param samples  where they are from, for the error
Outcome fit_outcome(const fit::FitResult& result, const report::FitInWords& words, const std::string& samples);
/// What is known is written whatever the exit code.
Stage<fit::FitResult> run_fit(const FitOptions& options, const Run& run);

}  // namespace bouncelab::stages
