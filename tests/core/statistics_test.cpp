// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "bouncelab/core/random.hpp"
#include "support/temporary_folder.hpp"

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

namespace {

/// @param value  of the k-th of n
void expect_the_median(std::size_t n, const std::function<double(std::size_t)>& value) {
  const test::TemporaryFolder folder;
  StreamedMedian streamed(folder.path(), "test");
  std::vector<double> values;
  for (std::size_t k = 0; k < n; ++k) {
    values.push_back(value(k));
    streamed.add(values.back());
  }
  EXPECT_EQ(streamed.median(), median(values)) << n;
}

TEST(StreamedMedian, IsTheMedianToTheLastBit) {
  constexpr std::size_t kHeld = StreamedMedian::kHeld;
  Random random(1, RandomStream::test, 0);
  for (const std::size_t n : {std::size_t{1}, std::size_t{4}, kHeld - 1, kHeld, kHeld + 1, 2 * kHeld + 3})
    expect_the_median(n, [&](std::size_t) { return random.normal(); });
}

TEST(StreamedMedian, IsTheMedianOfValuesThatAreTheSameOrHaveGaps) {
  constexpr std::size_t kMany = 2 * StreamedMedian::kHeld + 2;
  expect_the_median(kMany, [](std::size_t) { return 0.8; });
  expect_the_median(kMany, [](std::size_t k) { return k % 2 == 0 ? -1e300 : 1e-300; });  // one on either side
}

TEST(StreamedMedian, OfNoValuesIsAbsent) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(StreamedMedian(folder.path(), "test").median());
}

}  // namespace

}  // namespace bouncelab
