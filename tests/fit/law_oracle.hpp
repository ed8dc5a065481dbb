// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "drawn_balls.hpp"

namespace bouncelab::testing {

struct OracleEstimate {
  double eps, se;
};

/// What somebody finds who knows all but the law's constants, drag and contact time within what is known of the ball,
/// and the fluctuations themselves: form of the law, drag curve, standard deviations and correlations of the scatter,
/// which samples are outliers. Weighted least squares by Gauss and Newton; of a single drop with a loss of its own the
/// drop's eps. It leaves out that the last impact of a drop is heard only where it is fast enough (60 drops of steel as
/// v^(-1/4): .5 standard errors), and tau is not quite linear (60 superballs: intervals that hold in .87).
/// @return mean eps at the speeds
std::vector<OracleEstimate> oracle_estimates(const Cell& cell, const DrawnTable& table,
                                             const std::vector<double>& speeds_mps);

}  // namespace bouncelab::testing
