// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/error.hpp"

namespace bouncelab::fit {
namespace {

/// 60 seeds: pull mean good to 0.13, sd to 0.09, 68 % to 6, 95 % to 2.8; tolerances are three and a bit of these.
void expect_calibrated(const CalibrationConfig& config) {
  const auto result = calibrate(config);
  EXPECT_EQ(result.n_failed, 0u);
  ASSERT_EQ(result.rows.size(), 12u);
  for (const auto& row : result.rows) {
    SCOPED_TRACE(row.name);
    EXPECT_NEAR(row.pull_mean, 0.0, 0.42);
    EXPECT_NEAR(row.pull_sd, 1.0, 0.3);
    EXPECT_NEAR(row.coverage68, 0.683, 0.19);
    EXPECT_GT(row.coverage95, 0.86);
    // the kink smoothed over one standard error and the estimated scatter: a few percent at 3000 samples; of slopes,
    // whose errors go with their values, twice that at the few hundred of a window, and more the less they are known
    const bool is_slope = row.name.find("ing(") != std::string::npos;
    const bool is_known = !is_slope || row.cramer_rao < 0.1 * row.truth;
    EXPECT_NEAR(is_known ? row.mean_se / row.cramer_rao : 1.0, 1.0, is_slope ? 0.12 : 0.06);
  }
}

TEST(Calibration, TheFitKeepsItsWord) {
  CalibrationConfig config;
  config.n_samples = 3000;
  config.n_seeds = 60;
  expect_calibrated(config);
}

TEST(Calibration, TheFitKeepsItsWordUnderTimingNoise) {
  CalibrationConfig config;
  config.n_samples = 6000;
  config.n_seeds = 60;
  config.sigma_eps_at_1mps = 5e-4;
  expect_calibrated(config);
}

TEST(Calibration, BoundIsThatOfThePaperSizedRun) {
  // docs/physics.md: 220,000 points, normal scatter of sd .005 at all speeds: .0013, .0061, .013 for A. Here the
  // information of the location is that of a Laplace: with sides known it would be twice the normal's, with sides
  // unknown it is the same for equal sides (var 2 b^2/n against a spread of sqrt(2) b). Scatter goes as 1/v, so only
  // the order is compared.
  CalibrationConfig config;
  config.n_samples = 220000;
  config.n_seeds = 2;
  config.below_at_1mps = config.above_at_1mps = 0.005 / std::sqrt(2.0) * 0.6;
  config.intervals = IntervalMethod::covariance;
  const auto rows = calibrate(config).rows;
  const double paper[3] = {0.0013, 0.0061, 0.013};
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(rows[3 + i].cramer_rao, 0.5 * paper[i]);
    EXPECT_LT(rows[3 + i].cramer_rao, 2.0 * paper[i]);
  }
}

TEST(Calibration, RejectsNonsense) {
  CalibrationConfig config;
  config.n_samples = 5;
  EXPECT_THROW(calibrate(config), InvalidArgument);
  config = {};
  config.above_at_1mps = 0.0;
  EXPECT_THROW(calibrate(config), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::fit
