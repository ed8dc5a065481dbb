// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/posterior.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace bouncelab::fit {
namespace {

TEST(Posterior, IsThatOfACorrelatedNormalFromAPoorStart) {
  Eigen::Matrix3d covariance;
  covariance << 4.0, 1.5, 0.0, 1.5, 1.0, 0.2, 0.0, 0.2, 0.5;
  const Eigen::Matrix3d inverse = covariance.inverse();
  const Eigen::Vector3d mean(1.0, -2.0, 3.0);
  const auto log_density = [&](const Eigen::VectorXd& x) { return -0.5 * (x - mean).dot(inverse * (x - mean)); };
  const Posterior found = sample_posterior(log_density, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), 3000, 1);
  EXPECT_GT(found.effective, 1000.0);
  for (int i = 0; i < 3; ++i) {
    const double sd = std::sqrt(covariance(i, i)), error = 4.0 / std::sqrt(found.effective);  // four standard errors
    EXPECT_NEAR(found.mean[i], mean[i], error * sd);
    EXPECT_NEAR(found.covariance(i, i), covariance(i, i), 1.5 * error * covariance(i, i));
    const Interval ci = interval_of(found.draws.row(i).transpose(), found.weights, 0.95);
    EXPECT_NEAR(ci.lo, mean[i] - 1.96 * sd, 3.0 * error * sd);
    EXPECT_NEAR(ci.hi, mean[i] + 1.96 * sd, 3.0 * error * sd);
  }
}

TEST(Posterior, OfATentHasItsCorner) {
  // a likelihood with a corner, as a drop whose reservoir is almost empty makes it: exponential on either side
  const auto log_density = [](const Eigen::VectorXd& x) { return x[0] > 0.0 ? -3.0 * x[0] : x[0]; };
  const Posterior found =
      sample_posterior(log_density, Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Identity(1, 1), 4000, 2);
  EXPECT_NEAR(found.mean[0], 1.0 / 3.0 - 1.0, 4.0 / std::sqrt(found.effective));
}

TEST(Posterior, IntervalsOfEqualWeightsAreQuantiles) {
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(1001, 0.0, 1.0);
  const Interval ci = interval_of(values, Eigen::VectorXd::Constant(1001, 1.0 / 1001.0), 0.9);
  EXPECT_NEAR(ci.lo, 0.05, 1e-3);
  EXPECT_NEAR(ci.hi, 0.95, 1e-3);
}

TEST(Posterior, NormalDrawsHaveTheMomentsAskedFor) {
  Eigen::Matrix2d covariance;
  covariance << 2.0, -0.6, -0.6, 0.5;
  const Posterior found = normal_draws(Eigen::Vector2d(1.0, 2.0), covariance, 4000, 3);
  EXPECT_NEAR((found.draws * found.weights)[0], 1.0, 1e-12);
  const Eigen::MatrixXd about = found.draws.colwise() - found.mean;
  const Eigen::MatrixXd drawn = about * about.transpose() / 4000.0;
  EXPECT_NEAR(drawn(0, 1), -0.6, 0.08);  // five standard errors
  EXPECT_NEAR(drawn(0, 0), 2.0, 0.22);
}

}  // namespace
}  // namespace bouncelab::fit
