// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

/// Every combination of the values; the last axis varies fastest.
std::vector<Settings> combinations(const std::vector<SweepAxis>& axes);

/// "snr-db 20, radius-law constant:1e-3"
std::string text_of(const Settings& settings);

}  // namespace bouncelab::loop
