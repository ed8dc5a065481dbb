// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/core/progress.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// A study of the law's fit and of the slopes of p(eps) on samples drawn from a known law: speeds log-uniform,
/// two-exponential scatter whose mean distances go as 1/v, normal timing errors that go as 1/v and are stated.
struct CalibrationConfig {
  std::size_t n_samples = 20000;  ///< per seed, >= 100
  std::size_t n_seeds = 100;      ///< >= 2
  SeriesLaw law;
  double below_at_1mps = 4e-4, above_at_1mps = 3e-4;  ///< mean distances from the peak, > 0
  double sigma_eps_at_1mps = 0.0;                     ///< of timing, >= 0; 8.7e-4 doubles the width
  double v_lo_mps = 0.2, v_hi_mps = 1.4;
  IntervalMethod intervals = IntervalMethod::profile;
  std::uint64_t seed = 1;
  int n_threads = 0;  ///< 0: all cores; the result does not depend on it
};

/// Of one quantity (eps at a node, a constant A_i, a slope of p(eps)) over all seeds.
struct CalibrationRow {
  std::string name;
  double truth = 0.0;
  double cramer_rao = 0.0;  ///< bound on the standard error: expected information at the truth, scatter unknown
  double spread = 0.0;      ///< standard deviation of the estimates
  double mean_se = 0.0;     ///< of the standard errors stated
  double pull_mean = 0.0, pull_sd = 0.0;
  double coverage68 = 0.0, coverage95 = 0.0;
};

struct CalibrationResult {
  /// eps at 0.25, 0.6, 1.2 m/s, the constants, rising and falling slope in windows of 0.1 m/s about 0.3, 0.6, 1 m/s.
  std::vector<CalibrationRow> rows;
  std::size_t n_failed = 0;  ///< seeds whose fit did not converge: not in the rows
};

/// @throws InvalidArgument where a number is out of its range
CalibrationResult calibrate(const CalibrationConfig& config, const ProgressCallback& progress = {});

/// Samples of one seed of the study.
RestitutionSamples calibration_samples(const CalibrationConfig& config, std::uint64_t index);

}  // namespace bouncelab::fit
