// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/curve_at.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

namespace bouncelab::fit {
namespace {

const double kLo = std::log(0.2), kHi = std::log(3.0), kAnchor = std::log(0.7);

TEST(Slopes, IntegrateFromTheAnchor) {
  const Slopes slopes(kLo, kHi, kAnchor, 100);
  EXPECT_EQ(slopes.row(kAnchor).norm(), 0.0);
  for (const double x : {kLo, -1.0, -0.37, -0.3, 0.0, 0.61, kHi}) {
    constexpr int kSteps = 20'000;
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(slopes.n_knots());
    const double step = (x - kAnchor) / kSteps;
    for (int i = 0; i < kSteps; ++i) sum += step * slopes.slope_row(kAnchor + (i + 0.5) * step);
    // straight but at knots: off by a quarter of a step squared over their distance at each
    EXPECT_LT((slopes.row(x) - sum).lpNorm<Eigen::Infinity>(), 1e-7) << x;
  }
}

TEST(Slopes, AreStraightBetweenKnotsWithOneOfEachAtItsOwn) {
  const Slopes slopes(kLo, kHi, kAnchor, 100);
  for (const double x : {kLo, -0.8, 0.2, kHi}) EXPECT_NEAR(slopes.slope_row(x).sum(), 1.0, 1e-12) << x;
  // a constant slope is a straight line
  for (const double x : {kLo, -0.8, 0.2, kHi}) EXPECT_NEAR(slopes.row(x).sum(), x - kAnchor, 1e-12) << x;
}

TEST(Slopes, HaveThePrecisionOfAnOrnsteinUhlenbeckProcessAtTheKnots) {
  const Slopes slopes(kLo, kHi, kAnchor, 100);
  constexpr double kLost = 0.15;
  constexpr Eigen::Index kFirst = 2;
  for (const Slopes::Place& place : Slopes::places()) {
    Eigen::MatrixXd covariance(slopes.n_knots(), slopes.n_knots());
    for (Eigen::Index i = 0; i < slopes.n_knots(); ++i)
      for (Eigen::Index j = 0; j < slopes.n_knots(); ++j)
        covariance(i, j) = std::pow(place.sigma * kLost, 2) *
                           std::exp(-static_cast<double>(std::abs(i - j)) * slopes.distance() / place.ell);
    const Eigen::MatrixXd before = Eigen::MatrixXd::Constant(slopes.n_knots() + 3, slopes.n_knots() + 3, 0.5);
    Eigen::MatrixXd matrix = before;
    const double ln_det = slopes.add_precision(place, kLost, matrix, kFirst);
    const Eigen::MatrixXd added = matrix - before;
    const Eigen::MatrixXd precision = added.block(kFirst, kFirst, slopes.n_knots(), slopes.n_knots());
    // rounding times the condition, of neighbours with a correlation of .998 some 2e4, and of what .5 leaves of it
    EXPECT_LT((precision * covariance - Eigen::MatrixXd::Identity(slopes.n_knots(), slopes.n_knots())).norm(), 1e-8)
        << place.sigma << " " << place.ell;
    EXPECT_NEAR(added.norm(), precision.norm(), 1e-12 * precision.norm()) << "touches nothing else";
    const Eigen::LLT<Eigen::MatrixXd> root(covariance);
    EXPECT_NEAR(ln_det, -2.0 * root.matrixLLT().diagonal().array().log().sum(), 1e-8);
  }
}

TEST(Slopes, HavePlacesWhosePriorsAddUpToOne) {
  for (const auto* places : {&Slopes::places(), &Slopes::few_places()}) {
    double sum = 0.0;
    for (const Slopes::Place& place : *places) sum += std::exp(place.ln_prior);
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

TEST(Bases, PassThroughTheAnchorWithTheirDerivative) {
  for (const Base& base : bases()) {
    const double constant = base.constant_through(kAnchor, 0.85);
    EXPECT_NEAR(base.at(kAnchor, kAnchor, 0.85, constant).first, 0.85, 1e-9);
    EXPECT_NEAR(base.at(kAnchor, kAnchor, 0.85, constant).second, 1.0, 1e-12);
    for (const double x : {kLo, kHi}) {
      constexpr double kStep = 1e-5;
      const auto at = [&](double eps_0) {
        return base.at(x, kAnchor, eps_0, base.constant_through(kAnchor, eps_0)).first;
      };
      const double slope = (at(0.85 + kStep) - at(0.85 - kStep)) / (2.0 * kStep);
      EXPECT_NEAR(base.at(x, kAnchor, 0.85, constant).second, slope, 1e-6);  // of a search to 1e-11 or so
    }
  }
}

}  // namespace
}  // namespace bouncelab::fit
