// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/fit/calibration.hpp"
#include "command.hpp"

namespace bouncelab::cli {

struct CalibrateOptions {
  fit::CalibrationConfig config;
  bool covariance_intervals = false;
};

Outcome run_calibrate(const CalibrateOptions& options, const Run& run);

}  // namespace bouncelab::cli
