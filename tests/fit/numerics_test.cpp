// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "memory/posterior.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

// of 1: closed forms have a few roundings, GSL states 1e-12 here
constexpr double kTolerance = 1e-12;

TEST(Distributions, HaveTheirClosedForms) {
  for (const double x : {0.1, 1.0, 3.0, 8.0}) {
    EXPECT_NEAR(chi2_survival(x, 2.0), std::exp(-0.5 * x), kTolerance);
    EXPECT_NEAR(student_t_below(-x, 1.0), 0.5 - std::atan(x) / M_PI, kTolerance);
    EXPECT_NEAR(student_t_below(x, 2.0), 0.5 + 0.5 * x / std::sqrt(2.0 + x * x), kTolerance);
    EXPECT_NEAR(f_survival(x, 2.0, 7.0), std::pow(1.0 + 2.0 * x / 7.0, -3.5), kTolerance);
    EXPECT_NEAR(student_t_quantile(student_t_below(x, 5.0), 5.0), x, 1e-10 * x);
  }
}

TEST(Distributions, HaveTheirLimits) {
  EXPECT_EQ(chi2_survival(0.0, 3.0), 1.0);
  EXPECT_EQ(chi2_survival(1e9, 3.0), 0.0);
  EXPECT_EQ(f_survival(0.0, 3.0, 5.0), 1.0);
  EXPECT_EQ(f_survival(HUGE_VAL, 3.0, 5.0), 0.0);
}

TEST(Decompositions, GiveBackTheMatrix) {
  Eigen::MatrixXd m(3, 3);
  m << 4.0, 1.0, -0.5, 1.0, 3e-6, 1e-4, -0.5, 1e-4, 2e4;  // in units that differ
  m(1, 1) += 1.0;
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(3, 3), white = whitening(m, 1e-12);
  const auto root = cholesky(m);
  ASSERT_TRUE(root);
  // rounding times the condition, 1e4
  EXPECT_LT((root->inverse() * m - unit).norm(), 1e-11);
  EXPECT_LT((inverse(m) * m - unit).norm(), 1e-11);
  EXPECT_LT((white.transpose() * m * white - unit).norm(), 1e-11);
  EXPECT_NEAR(root->log_determinant(), eigenvalues(m).array().log().sum(), 1e-11);
  EXPECT_FALSE(cholesky(m - 5.0 * unit));
}

TEST(Decompositions, RotationKeepsLengthsAndHasItsFirstColumnAlongTheDirection) {
  const Eigen::Vector4d direction(-3.0, 0.0, 1.0, 2.0);
  const Eigen::MatrixXd rotation = rotation_along(direction);
  EXPECT_LT((rotation.transpose() * rotation - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-14);
  EXPECT_NEAR(std::abs(rotation.col(0).dot(direction)), direction.norm(), 1e-14 * direction.norm());
}

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
