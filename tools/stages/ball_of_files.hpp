// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stage_options/ball_choice.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// `choice`, where a part is not named that of the command which wrote the files (their provenance), if it had one.
/// @throws FileError where the provenance cannot be read; InvalidArgument where the files were made with several
BallChoice with_provenance(BallChoice choice, const std::vector<std::string>& files);

/// Whether the balls of simulated impacts flew through air; absent where the files are no simulation's.
std::optional<bool> air_of_simulation(const std::vector<std::string>& files);

/// Gravity of the command that wrote the files, simulate or detect; absent where it is not known.
std::optional<double> gravity_of(const std::vector<std::string>& files);

/// What was understood, as a line.
std::string ball_line(const BallChoice& choice);

}  // namespace bouncelab::stages
