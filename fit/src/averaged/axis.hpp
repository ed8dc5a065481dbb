// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace bouncelab::fit {

/// Places of one parameter, in ln.
struct Axis {
  std::vector<double> at;
  double prior_sd = 0.0;
  double distance() const { return at.size() > 1 ? at[1] - at[0] : 0.0; }
};
/// @param prior_sd  0: the parameter is known, there is one place. @param reach  of the places to either side of
/// `middle`
Axis axis_of(double prior_sd, double middle, double reach);

/// A place between those of an axis: cubic convolution of four neighbours, exact where a function is a parabola.
/// Source: Keys, IEEE Trans. ASSP 29, 1153 (1981), doi:10.1109/TASSP.1981.1163711.
struct FinePlace {
  double at = 0.0;
  std::vector<std::pair<std::size_t, double>> neighbours;  ///< with their weights
  std::size_t below = 0, above = 0;                        ///< the places of the axis to either side
};
/// Places between all those of an axis.
std::vector<FinePlace> finer(const Axis& axis);

inline constexpr double kReach = 2.4;     // of an axis, in standard deviations: 98 % of a normal prior
inline constexpr double kApart = 1.1;     // places of an axis at most, in ln: from one ball to another
inline constexpr std::size_t kFiner = 8;  // places by interpolation for each one computed

}  // namespace bouncelab::fit
