// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bouncelab {
namespace {

constexpr int kN = 200000;

TEST(Random, SameKeyAndCounterGiveTheSameWords) {
  EXPECT_EQ(philox_block(1, RandomStream::test, 2, 3), philox_block(1, RandomStream::test, 2, 3));
  EXPECT_NE(philox_block(1, RandomStream::test, 2, 3), philox_block(1, RandomStream::noise, 2, 3));
  EXPECT_NE(philox_block(1, RandomStream::test, 2, 3), philox_block(2, RandomStream::test, 2, 3));
}

TEST(Random, UniformHasTheMomentsOfTheUniformLaw) {
  Random random(7, RandomStream::test, 0);
  double sum = 0, sum2 = 0;
  for (int k = 0; k < kN; ++k) {
    const double u = random.uniform();
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    sum2 += u * u;
  }
  // 5 standard errors: sd(u) = 1/sqrt(12), sd(u^2) = sqrt(4/45)
  EXPECT_NEAR(sum / kN, 0.5, 5 * std::sqrt(1.0 / 12 / kN));
  EXPECT_NEAR(sum2 / kN, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / kN));
}

TEST(Random, NormalHasTheMomentsOfTheNormalLaw) {
  Random random(7, RandomStream::test, 1);
  double sum = 0, sum2 = 0, sum4 = 0;
  for (int k = 0; k < kN; ++k) {
    const double x = random.normal();
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
  }
  // 5 standard errors: var(x^2) = 2, var(x^4) = 96
  EXPECT_NEAR(sum / kN, 0.0, 5 / std::sqrt(kN));
  EXPECT_NEAR(sum2 / kN, 1.0, 5 * std::sqrt(2.0 / kN));
  EXPECT_NEAR(sum4 / kN, 3.0, 5 * std::sqrt(96.0 / kN));
}

TEST(Random, ExponentialHasMeanOne) {
  Random random(7, RandomStream::test, 2);
  double sum = 0;
  for (int k = 0; k < kN; ++k) sum += random.exponential();
  EXPECT_NEAR(sum / kN, 1.0, 5 / std::sqrt(kN));  // 5 standard errors, sd = 1
}

}  // namespace
}  // namespace bouncelab
