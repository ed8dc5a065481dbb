// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/loop/memory_calibration.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

struct CalibrateOptions {
  fit::CalibrationConfig config;
  bool memory = false;
  loop::MemoryCalibrationConfig with_memory;
  std::vector<double> drops{5.0, 100.0};  ///< least and largest number
  std::string out;                        ///< table of experiments; empty: none
};
/// All but the file.
Description members_of(const CalibrateOptions*);
/// @throws InvalidArgument where options of the two kinds of calibration are given together
void check_calibrate_options(const CalibrateOptions& options, const Given& given);

/// What the options describe. @throws InvalidArgument
fit::CalibrationConfig calibration_config(const CalibrateOptions& options, const CommonOptions& common);
/// The same where options.memory is set. @throws InvalidArgument
loop::MemoryCalibrationConfig memory_calibration_config(const CalibrateOptions& options, const CommonOptions& common);

/// What --json prints of the study with memory.
Object summary_of(const std::vector<loop::MemoryCalibrationGroup>& groups);

Outcome run_calibrate(const CalibrateOptions& options, const Run& run);

}  // namespace bouncelab::stages
