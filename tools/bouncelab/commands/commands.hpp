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

struct ConvertOptions {
  std::string input;
  std::vector<std::string> outputs;
  ForeignFileOptions foreign;  ///< with the recording, of several in a table the one that is wanted
};

/// Onsets from a table or from a sound editor's marks, to any of these.
Outcome run_convert(const ConvertOptions& options, const Run& run);

}  // namespace bouncelab::cli
