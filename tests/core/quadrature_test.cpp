// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(GaussLegendre, TheTablesAreTheRulesTheyName) {
  // a few units in the last place, of the generator by Newton's method and of the 16 digits of the tables
  constexpr double kRounding = 4e-16;
  const QuadratureRule six = gauss_legendre(6, 0.0, 1.0), twelve = gauss_legendre(12, -1.0, 1.0);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(kGaussLegendre6.nodes[k], six.nodes[k], kRounding);
    EXPECT_NEAR(kGaussLegendre6.weights[k], six.weights[k], kRounding);
    EXPECT_NEAR(kGaussLegendre12Positive.nodes[k], twelve.nodes[6 + k], kRounding);
    EXPECT_NEAR(kGaussLegendre12Positive.weights[k], twelve.weights[6 + k], kRounding);
    EXPECT_NEAR(-kGaussLegendre12Positive.nodes[k], twelve.nodes[5 - k], kRounding);
  }
}

}  // namespace
}  // namespace bouncelab
