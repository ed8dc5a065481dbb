// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/fit/histogram_fit.hpp"

namespace bouncelab::fit {

/// Peak and mean distances from it: where the search for every shape starts.
struct ShapeStart {
  double peak = 0.0, b_below = 1.0, b_above = 1.0;
};

/// Two exponentials, normal, Gumbel and Student t on the same bins; see ShapeFit.
///
/// What a shape expects of the bins is its integral over quarter bins, reaching six timing errors beyond the range,
/// moved to other bins as the normal timing errors (in up to 16 classes) would. Discretisation changes a bin's content
/// by less than 1 % of itself for shapes wider than a quarter bin.
/// @param tau    timing errors of the samples that the bins count
/// @return in the order above; delta_aic is 0 for the first
std::vector<ShapeFit> fit_shapes(const Bins& bins, const std::vector<double>& tau, const ShapeStart& start);

}  // namespace bouncelab::fit
