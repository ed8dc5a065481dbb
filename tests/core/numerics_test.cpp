// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/numerics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab {
namespace {

TEST(GaussLegendre, IsExactForPolynomialsUpToDegreeTwiceThePointsLessOne) {
  for (const int n : {1, 2, 5, 12, 64}) {
    const QuadratureRule rule = gauss_legendre(n, -1.0, 3.0);
    for (int degree = 0; degree <= std::min(2 * n - 1, 9); ++degree) {
      double sum = 0.0;
      for (std::size_t k = 0; k < rule.nodes.size(); ++k) sum += rule.weights[k] * std::pow(rule.nodes[k], degree);
      const double exact = (std::pow(3.0, degree + 1) - std::pow(-1.0, degree + 1)) / (degree + 1);
      // rounding of up to 64 terms, each good to 1e-15
      EXPECT_NEAR(sum, exact, 1e-13 * std::pow(3.0, degree + 1)) << n << " points, degree " << degree;
    }
  }
}

// the standard library's own errors are a few 1e-14 at the larger arguments
TEST(Bessel, FunctionsAreThoseOfTheStandardLibrary) {
  for (const int n : {0, 1, 2, 7, 30})
    for (const double x : {0.0, 1e-3, 0.4, 2.0, 9.7, 31.0, 120.0}) {
      EXPECT_NEAR(bessel_j(n, x), std::cyl_bessel_j(n, x), 1e-13) << n << " " << x;
      const double i = std::cyl_bessel_i(n, x) * std::exp(-x);
      EXPECT_NEAR(scaled_bessel_i(n, x), i, 1e-12 * i) << n << " " << x;
    }
  EXPECT_EQ(bessel_j(200, 0.1), 0.0) << "too small for a number";
}

TEST(RootBetween, IsFoundToRoundingAndRefusesAFunctionWithoutAChangeOfSign) {
  EXPECT_DOUBLE_EQ(root_between([](double x) { return x * x - 2.0; }, 0.0, 2.0), std::sqrt(2.0));
  EXPECT_EQ(root_between([](double x) { return x - 1.0; }, 1.0, 3.0), 1.0) << "at an end";
  EXPECT_THROW(root_between([](double x) { return x * x + 1.0; }, 0.0, 2.0), InvalidArgument);
}

std::vector<double> some_values(std::size_t n) {
  Random random(1, RandomStream::test, n);
  std::vector<double> values;
  for (std::size_t k = 0; k < n; ++k) values.push_back(random.normal());
  return values;
}

TEST(OrderStatistic, IsTheValueAtThatPlaceOfTheSortedOnes) {
  for (const std::size_t n : {1u, 2u, 7u, 100u}) {
    const std::vector<double> values = some_values(n);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t k = 0; k < n; ++k) EXPECT_EQ(order_statistic(values, k), sorted[k]);
  }
}

TEST(Median, IsTheMiddleOneOrTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(median({3.0}), 3.0);
  EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0, 2.0}), 2.5);
  EXPECT_EQ(median({1.0, 1.0, 1.0, 5.0}), 1.0);
}

TEST(UpperMedian, IsAlwaysOneOfTheValues) {
  EXPECT_EQ(upper_median({3.0}), 3.0);
  EXPECT_EQ(upper_median({2.0, 1.0}), 2.0);
  EXPECT_EQ(upper_median({4.0, 1.0, 3.0, 2.0}), 3.0);
}

}  // namespace
}  // namespace bouncelab
