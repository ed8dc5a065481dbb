// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/report/answer.hpp"
#include "stage_options/options.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// What the options describe, with the positions of their file. @throws InvalidArgument, FileError
fit::RestitutionConfig restitution_config(const RestitutionOptions& options);

std::string text_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);
/// What --json prints.
Object summary_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);

/// The samples are in the file only: there may be more than the memory holds.
Stage<fit::RestitutionCounts> run_restitution(const RestitutionOptions& options, const Run& run);

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

/// What stood on the command line was not taken, it was given.
void leave_out_given(const Given& given, std::vector<report::Taken>& taken);

/// Text and notes; exit code 1 where there is no curve.
/// @param samples  where they are from, for the error
Outcome fit_outcome(const fit::FitResult& result, const report::FitInWords& words, const std::string& samples);
/// What is known is written whatever the exit code.
Stage<fit::FitResult> run_fit(const FitOptions& options, const Run& run);

struct RoughnessOptions {
  std::vector<std::string> samples;  ///< files
  std::string out;                   ///< empty: none
  fit::RoughnessConfig config;
  BallChoice world;  ///< in place of what the samples say
};

/// Exit code 1 where the scatter is not that of a rough ball, or there are too few impacts to know.
Outcome run_roughness(const RoughnessOptions& options, const Run& run);

}  // namespace bouncelab::stages
