// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "bouncelab/loop/closed_loop.hpp"
#include "bouncelab/loop/settings.hpp"

namespace bouncelab::loop {

/// A number of one point of a sweep.
struct SweepValue {
  std::string name;             ///< of the column
  std::optional<double> value;  ///< absent: not known
  bool is_count = false;        ///< an integer
};

/// The result of the closed loop for one combination of settings.
struct SweepPoint {
  Settings settings;
  std::vector<SweepValue> values;  ///< the same names in the same order at every point of a sweep
  std::string failure;             ///< which part of the method fails here, in words; empty: none
};

/// The numbers of a point and the judgement of it. The method is said to fail at a point, by the first of these that
/// holds, where
///   - no impact was found, fewer than 99 % of the impacts were found, or more than 1 % of those found are none;
///   - eps at a node, from sound, is further from that from the true times than the standard error of the latter;
///   - a slope of p(eps), from sound, differs by more than a tenth from that from the true times.
/// @param node_speeds_mps  speeds at which eps is compared [m/s], as in the configuration of the loop
SweepPoint sweep_point(Settings settings, const LoopResult& loop, const std::vector<double>& node_speeds_mps);

/// A column for each setting, each number, and the failure in words (named `trouble`). All points of one sweep; at
/// least one.
Table to_table(const std::vector<SweepPoint>& points);

}  // namespace bouncelab::loop
