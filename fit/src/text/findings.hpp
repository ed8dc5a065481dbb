// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/fit.hpp"

namespace bouncelab::fit {

/// "a ball of 3 mm radius and 7900 kg/m^3"
std::string describe(const Ball& ball);

/// What a user must know before using the result, most important first.
/// @param used  the samples that were fitted
std::vector<std::string> warnings_of(const FitResult& result, const RestitutionSamples& used);

/// The questions that a reader brings (five; with several recordings a sixth, whether they agree), answered in a
/// sentence or two from the numbers of the result.
std::vector<Finding> findings_of(const FitResult& result);

}  // namespace bouncelab::fit
