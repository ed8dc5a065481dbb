// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/densities.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

TEST(Student3, IntegratesToOneWhateverItsWidth) {
  for (const double width : {1e-4, 0.1, 1.0, 30.0})
    // a trigonometric polynomial after the substitution: exact but for rounding
    EXPECT_NEAR(test::integral_over_line(0.0, width, 400, [&](double x) { return student3(x, width); }), 1.0, 1e-12);
}

TEST(Student3, HasTheDistributionOfTheTables) {
  // P(0 < t < x) of three degrees of freedom: 0.475 at 3.182446, 0.495 at 5.840909 (tables, six decimals)
  const auto within = [](double x) { return test::integral(0.0, x, 20000, [](double t) { return student3(t, 1.0); }); };
  EXPECT_NEAR(within(3.182446), 0.475, 1e-7);
  EXPECT_NEAR(within(5.840909), 0.495, 1e-7);
}

TEST(Student3, IsEvenAndScalesWithItsWidth) {
  EXPECT_EQ(student3(0.7, 0.2), student3(-0.7, 0.2));
  EXPECT_NEAR(student3(0.7, 0.2), student3(3.5, 1.0) / 0.2, 1e-14);
  // tails fall as the fourth power, where a normal density would be gone
  EXPECT_NEAR(student3(2000.0, 1.0) / student3(1000.0, 1.0), 1.0 / 16.0, 1e-6);
}

}  // namespace
}  // namespace bouncelab::detection
