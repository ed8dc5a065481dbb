// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/curve_sum.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bouncelab::fit {
namespace {

constexpr double kQuantileError = 1e-10;  // bisection to 1e-12 of quantities of the size of 1

TEST(NormalSum, OfOneHasItsMedianAndQuantiles) {
  const Estimate e = estimate_of({{0.3, 0.8, 0.01}}, 0.0, 1.0);
  EXPECT_NEAR(e.value, 0.8, kQuantileError);
  EXPECT_NEAR(e.ci68->lo, 0.79, kQuantileError);
  EXPECT_NEAR(e.ci68->hi, 0.81, kQuantileError);
  EXPECT_NEAR(e.ci95->lo, 0.8 - 0.01 * 1.959963984540054, kQuantileError);
  EXPECT_NEAR(e.ci95->hi, 0.8 + 0.01 * 1.959963984540054, kQuantileError);
  EXPECT_NEAR(*e.se, 0.01, kQuantileError);
}

TEST(NormalSum, OfTwoFarApartHasAnEndInEachByItsShare) {
  // 2.5 % of the whole are 5 % of its half, beyond 1.644854; of a quarter 10 %, beyond 1.281552
  const Estimate halves = estimate_of({{7.0, -0.3, 0.01}, {7.0, 0.3, 0.02}}, -1.0, 1.0);
  EXPECT_NEAR(halves.ci95->lo, -0.3 - 0.01 * 1.644853627, 1e-9);
  EXPECT_NEAR(halves.ci95->hi, 0.3 + 0.02 * 1.644853627, 1e-9);
  const Estimate quarter = estimate_of({{3.0, -0.3, 0.01}, {1.0, 0.3, 0.02}}, -1.0, 1.0);
  EXPECT_NEAR(quarter.ci95->hi, 0.3 + 0.02 * 1.281551566, 1e-9);
  EXPECT_NEAR(quarter.value, -0.3 + 0.01 * 0.430727300, 1e-9);  // half of the whole is two thirds of that
}

TEST(NormalSum, IsCutWhereTheQuantityEnds) {
  // half a normal: quantiles p/2 of the whole one
  const Estimate below_1 = estimate_of({{1.0, 1.0, 0.1}}, 0.0, 1.0), above_0 = estimate_of({{1.0, 0.0, 0.1}}, 0.0, 1.0);
  EXPECT_NEAR(below_1.value, 1.0 - 0.1 * 0.674489750, 1e-9);
  EXPECT_NEAR(below_1.ci95->lo, 1.0 - 0.1 * 2.241402728, 1e-9);
  EXPECT_NEAR(below_1.ci95->hi, 1.0 - 0.1 * 0.031337982, 1e-9);
  EXPECT_NEAR(above_0.value, 0.1 * 0.674489750, 1e-9);
  EXPECT_NEAR(above_0.ci95->hi, 0.1 * 2.241402728, 1e-9);
  // of one far wider than where it may be nearly even shares remain
  const Estimate wide = estimate_of({{1.0, 0.5, 1e3}}, 0.0, 1.0);
  EXPECT_NEAR(wide.ci95->lo, 0.025, 1e-6);
  EXPECT_NEAR(wide.value, 0.5, 1e-6);
  EXPECT_NEAR(wide.ci68->hi, 0.841344746, 1e-6);
}

TEST(NormalSum, KeepsTheWeightsOfThoseThatAreCut) {
  // a weight is of what is within: half of it in (0.5, 1) by a normal that is cut in two there
  const Estimate e = estimate_of({{1.0, 0.2, 0.01}, {1.0, 1.0, 0.1}}, 0.0, 1.0);
  EXPECT_NEAR(e.ci95->lo, 0.2 - 0.01 * 1.644853627, 1e-9);
  EXPECT_NEAR(e.ci95->hi, 1.0 - 0.1 * 0.062706778, 1e-9);  // 5 % of the half normal: 2.5 % of the whole
}

TEST(NormalSum, LeavesOutThoseThatLieBeyondAndCutsNothingWhereAllDo) {
  const Estimate one = estimate_of({{1.0, 0.9, 0.01}, {1.0, 1.5, 0.01}, {1.0, -0.5, 0.01}}, 0.0, 1.0);
  EXPECT_NEAR(one.value, 0.9, kQuantileError);
  EXPECT_NEAR(*one.se, 0.01, kQuantileError);
  const Estimate none = estimate_of({{1.0, 1.08, 0.001}}, 0.0, 1.0);
  EXPECT_NEAR(none.value, 1.08, kQuantileError);  // units or order of the times are wrong, and a warning says so
  EXPECT_NEAR(*none.se, 0.001, kQuantileError);
}

}  // namespace
}  // namespace bouncelab::fit
