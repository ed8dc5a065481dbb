// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {

constexpr double kMostOfOne = 3.0;  // widths by which one observation moves a running mean at most

/// Density of Student's t with three degrees of freedom, scaled: a normal core, tails that forgive. Integrates to one.
/// @param width  > 0, in units of x
inline double student3(double x, double width) {
  const double width2 = width * width;
  const double core = width2 + x * x * (1.0 / 3.0);  // (1 + z^2 / 3) width^2
  return 2.0 / (kPi * std::numbers::sqrt3) * width2 * width / (core * core);
}

}  // namespace bouncelab::detection
