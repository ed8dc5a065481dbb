// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/streamed_median.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/statistics.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
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
