// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab::loop {

struct LoopResult;

/// A setting that runs through several values.
struct SweepAxis {
  std::string option;
  std::vector<std::string> values;
};

/// Setting and value, in the order of the axes.
using Settings = std::vector<std::pair<std::string, std::string>>;

/// The most combinations of one sweep. Each is a closed loop, which takes a second or more: 10 000 are hours.
inline constexpr std::size_t kMostCombinations = 10'000;

/// The combinations of the values, that of the last axis varying fastest; without axes one without settings.
/// @throws InvalidArgument where there are more than kMostCombinations
std::vector<Settings> combinations(const std::vector<SweepAxis>& axes);

/// "snr-db 20, radius-law constant:1e-3"
std::string text_of(const Settings& settings);

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
Description members_of(const SweepPoint*);

/// The numbers of a point and the judgement of it. The method is said to fail at a point, by the first of these that
/// holds, where
///   - no impact was found, fewer than 99 % of the impacts were found, or more than 1 % of those found are none;
///   - eps at a node, from sound, is further from that from the true times than the standard error of the latter;
///   - a slope of p(eps), from sound, differs by more than a tenth from that from the true times.
SweepPoint sweep_point(Settings settings, const LoopResult& loop);

/// A column for each setting, each number, and the failure in words (named `trouble`). All points of one sweep; at
/// least one.
Table to_table(const std::vector<SweepPoint>& points);

}  // namespace bouncelab::loop
