// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stage_options/options.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// `choice`, where a part is not named that of the command which wrote the files (their provenance), if it had one.
/// @throws FileError where the provenance cannot be read; InvalidArgument where the files were made with several
BallChoice with_provenance(BallChoice choice, const std::vector<std::string>& files);

/// Puts the ball, the plate and how impacts were simulated, where it is the same of all files, among the parameters of
/// what is made of them: only the provenance beside a file is read, not those of its inputs.
/// @param files  at least one
void keep_conditions_of(const std::vector<std::string>& files, Parameters& parameters);

/// What is known of how the files' impacts came about, where no option says otherwise: ball and plate; of a simulation
/// gravity and whether there was air (contacts take no time in it). @throws as with_provenance
RestitutionOptions with_conditions_of(const std::vector<std::string>& files, RestitutionOptions options,
                                      const Given& given);
/// The same of a whole run, among whose parameters it stands then.
RestitutionOptions with_conditions_of(const std::vector<std::string>& files, const RestitutionOptions& options,
                                      Run& run);

/// What was understood, as a line.
std::string ball_line(const BallChoice& choice);

}  // namespace bouncelab::stages
