// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Probability of a standard normal below z.
double normal_below(double z);

/// One normal distribution of a sum of them.
struct NormalPart {
  double weight = 0.0, mean = 0.0, sd = 0.0;
};

/// Quantiles of the sum: the median, 68.27 and 95 % intervals, and half the former as standard error.
/// @param parts      weights need not add up to 1
/// @param lo, hi     between which the quantity lies: the normals are cut off there, unless all lie beyond
Estimate estimate_of(const std::vector<NormalPart>& parts, double lo, double hi);

}  // namespace bouncelab::fit
