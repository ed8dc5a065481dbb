// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stages/files/foreign_files.hpp"
#include "stages/stages.hpp"

namespace bouncelab::cli {

using namespace stages;

/// The catalogue: balls, materials of balls, plates, each with its source.
Outcome run_balls();

struct CompletionOptions {
  std::string shell;               ///< bash, zsh, fish; words: what their scripts ask for
  std::vector<std::string> typed;  ///< of `words`, the word to complete last
};
Outcome run_completion(const CompletionOptions& options, const Run& run);

struct DemOptions {
  std::string fit;
  std::string code = "lammps";
  std::string model;  ///< empty: the first that the fit has for the code
  std::optional<double> youngs_modulus_pa;
};

/// Prints what the fit has for the code. Exit code 1 where it has nothing of the kind.
/// @throws FileError where the file is no fit.json
Outcome run_dem(const DemOptions& options, const Run& run);

struct ConvertOptions {
  std::string input;
  std::vector<std::string> outputs;
  ForeignFileOptions foreign;  ///< with the recording, of several in a table the one that is wanted
};

/// Onsets from a table or from a sound editor's marks, to any of these.
Outcome run_convert(const ConvertOptions& options, const Run& run);

struct CompareOptions {
  std::vector<std::string> samples;  ///< files: samples, or sound
  std::string out;                   ///< folder
  std::string groups;                ///< table of plates and dates; empty: none
  std::string title;                 ///< of the page; empty: of the folder
  RestitutionOptions restitution;    ///< of sound
};

/// Exit code 1 where too few recordings can be compared; what is known of each is written all the same.
Outcome run_compare(const CompareOptions& options, const Run& run);

struct AnalyzeOptions {
  std::string out;
  DetectOptions detect;
  RestitutionOptions restitution;  ///< with the ball, which the fit reads in the samples
  FitOptions fit;
  bool diagnostics = false;  ///< details of each drop in the report
};

Outcome run_analyze(const AnalyzeOptions& options, const Run& run);

}  // namespace bouncelab::cli
