// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "numerics/distributions.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

// of 1: closed forms have a few roundings, GSL states 1e-12 here
constexpr double kTolerance = 1e-12;

TEST(Distributions, HaveTheirClosedForms) {
  for (const double x : {0.1, 1.0, 3.0, 8.0}) {
    EXPECT_NEAR(chi2_survival(x, 2.0), std::exp(-0.5 * x), kTolerance);
    EXPECT_NEAR(student_t_below(-x, 1.0), 0.5 - std::atan(x) / M_PI, kTolerance);
    EXPECT_NEAR(student_t_below(x, 2.0), 0.5 + 0.5 * x / std::sqrt(2.0 + x * x), kTolerance);
    EXPECT_NEAR(student_t_density(x, 1.0), 1.0 / (M_PI * (1.0 + x * x)), kTolerance);
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

}  // namespace
}  // namespace bouncelab::fit
