// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stage_options/restitution_options.hpp"
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

}  // namespace bouncelab::stages
