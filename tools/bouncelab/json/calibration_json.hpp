// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/loop/memory_calibration.hpp"

namespace bouncelab::cli {

/// What `calibrate --memory --json` prints: the groups of experiments with their rows.
std::string memory_calibration_json(const std::vector<loop::MemoryCalibrationGroup>& groups);

}  // namespace bouncelab::cli
