// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// A study of the law's fit and of the slopes of p(eps) on drops of known law whose scatter has the closed form of a
/// rough ball (docs/physics.md): each drop from v_hi down to v_lo,
///
///   eps~ = eps(v) + (1 + e) (theta . u / v - c theta^2),   u' = u - c (1 + e) v theta,   v' = eps~ v
///
/// with c = 1/(1 + J/(m R^2)),
///
/// theta the offset of the contact point over the ball's radius (two components, normal, variance offset_variance), u
/// the velocity gained sideways and by spin, 0 at release. Impacts of one drop share u: they are not independent. To
/// each sample a timing error is added, normal, independent, stated, going as 1/v.
///
/// Near the release, where the ball has gained little velocity, the width of the scatter falls to zero, which no smooth
/// function of v alone follows: the rough ball's own bias, some -1e-5 of eps(1.2 m/s), shows in the means of the pulls.
struct CalibrationConfig {
  std::size_t n_samples = 20000;  ///< per seed, >= 100; some 95 a drop, the last drop may be shorter
  std::size_t n_seeds = 100;      ///< >= 2
  SeriesLaw law;
  double offset_variance = 2.8e-5;  ///< > 0, <= 1e-3; the default is that of 1e6 asperities of radii uniform in
                                    ///< (0.5, 1.5) 1e-3, and gives slopes of 620 at .3, 1350 at .6, 3000 at 1 m/s
  double inertia_factor = kSolidBallInertia;  ///< J/(m R^2) of the ball, in (0, 1]
  double sigma_eps_at_1mps = 0.0;             ///< of timing, >= 0; 8.7e-4 is as wide as the scatter at .3 m/s
  /// Speeds; drops are released from 0.9 to 1 of the height that belongs to v_hi, their first impact is no sample.
  double v_lo_mps = 0.2, v_hi_mps = 1.4;
  IntervalMethod intervals = IntervalMethod::profile;
  std::uint64_t seed = 1;
  int n_threads = 0;  ///< 0: all cores; the result does not depend on it
};

/// Of one quantity (eps at a node, a constant A_i, a slope of p(eps)) over all seeds.
struct CalibrationRow {
  std::string name;
  /// Slopes: 1 / b_down and 1 / b_up at the window's centre, b_down,up = c (1 + e) s2 (sqrt(1 + S / v^2) +- 1), with S
  /// the sum of (1 + e)^2 v^2 over the drop's earlier impacts, taken along the path without scatter and averaged over
  /// the heights of release.
  double truth = 0.0;
  /// Cramer-Rao bound on the standard error that holds if samples were independent: expected information at the truth,
  /// scatter unknown. Impacts of one drop are not: slopes must miss it.
  double bound_independent = 0.0;
  double spread = 0.0;   ///< standard deviation of the estimates
  double mean_se = 0.0;  ///< of the standard errors stated
  double pull_mean = 0.0, pull_sd = 0.0;
  double coverage68 = 0.0, coverage95 = 0.0;
};

struct CalibrationResult {
  /// eps at 0.25, 0.6, 1.2 m/s, the constants, rising and falling slope in windows of 0.1 m/s about 0.3, 0.6, 1 m/s.
  std::vector<CalibrationRow> rows;
  std::size_t n_failed = 0;  ///< seeds whose fit did not converge: not in the rows
};

/// All seeds, one after the other, each on all threads.
/// @throws InvalidArgument where a number is out of its range
CalibrationResult calibrate(const CalibrationConfig& config, const ProgressCallback& progress = {});

/// Samples of one seed of the study.
RestitutionSamples calibration_samples(const CalibrationConfig& config, std::uint64_t index);

}  // namespace bouncelab::fit
