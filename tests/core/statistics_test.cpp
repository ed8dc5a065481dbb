// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/numerics.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "bouncelab/core/random.hpp"

namespace bouncelab {
namespace {

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

TEST(Quantile, InterpolatesBetweenTheRanks) {
  const std::vector<double> values{0.0, 1.0, 4.0};
  EXPECT_EQ(quantile(values, 0.0), 0.0);
  EXPECT_EQ(quantile(values, 0.25), 0.5);
  EXPECT_EQ(quantile(values, 0.75), 2.5);
  EXPECT_EQ(quantile(values, 1.0), 4.0);
  std::vector<double> many = some_values(51);
  std::sort(many.begin(), many.end());
  EXPECT_EQ(quantile(many, 0.5), median(many));
}

}  // namespace
}  // namespace bouncelab
