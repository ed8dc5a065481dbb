// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

/// The speeds of comparison (comparison_speed_mps) that samples reach, rising: from the nearest to the slowest of them
/// on to the nearest to the fastest. The slowest and the fastest twentieth of the samples do not count.
/// @param samples  at least 1, v > 0
std::vector<double> speeds_of_comparison(const RestitutionSamples& samples);

}  // namespace bouncelab::fit
