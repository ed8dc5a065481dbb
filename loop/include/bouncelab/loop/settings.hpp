// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace bouncelab::loop {

/// A setting that runs through several values.
struct SweepAxis {
  std::string option;
  std::vector<std::string> values;
};

/// Setting and value, in the order of the axes.
using Settings = std::vector<std::pair<std::string, std::string>>;

/// The most combinations of one sweep. Each is a closed loop, which takes a second or more: 10 000 are hours.
inline constexpr std::size_t kMostCombinations = 10'000;

/// How many combinations of the values there are; 1 without axes.
/// @throws InvalidArgument where there are more than kMostCombinations
std::size_t n_combinations(const std::vector<SweepAxis>& axes);

/// A combination of the values; the last axis varies fastest.
/// @param index  below n_combinations(axes)
Settings combination(const std::vector<SweepAxis>& axes, std::size_t index);

/// "snr-db 20, radius-law constant:1e-3"
std::string text_of(const Settings& settings);

}  // namespace bouncelab::loop
