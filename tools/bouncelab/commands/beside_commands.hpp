// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

/// The catalogue: balls, materials of balls, plates, each with its source.
Outcome run_balls();

struct CompletionOptions {
  std::string shell;               ///< bash, zsh, fish; words: what their scripts ask for
  std::vector<std::string> typed;  ///< of `words`, the word to complete last
};
Outcome run_completion(const CompletionOptions& options);

}  // namespace bouncelab::cli
