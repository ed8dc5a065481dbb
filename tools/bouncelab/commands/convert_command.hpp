// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stages/files/foreign_files.hpp"
#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

struct ConvertOptions {
  std::string input;
  std::vector<std::string> outputs;
  ForeignFileOptions foreign;  ///< with the recording, of several in a table the one that is wanted
};

/// Onsets from a table or from a sound editor's marks, to any of these.
Outcome run_convert(const ConvertOptions& options, const Run& run);

}  // namespace bouncelab::cli
