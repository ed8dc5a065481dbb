// SPDX-License-Identifier: GPL-3.0-or-later
// Gaps between the time stamps of blocks: lost ones, jitter, rounding, overlaps, clocks that drift.
#include "io/coded_sound.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

constexpr double kBlock_s = 1024.0 / 44100.0;  // of AAC

/// Blocks of which some are lost, each stamped with its time as `stamp` distorts it.
std::vector<StampedBlock> blocks(const std::set<int>& lost, const std::function<double(double)>& stamp) {
  std::vector<StampedBlock> all;
  for (int k = 0; k < 400; ++k)
    if (!lost.contains(k)) all.push_back({stamp(kBlock_s * k), kBlock_s});
  return all;
}

double exact(double t_s) { return t_s; }
double in_milliseconds(double t_s) { return std::round(1e3 * t_s) / 1e3; }

TEST(StampGaps, AreThoseOfTheBlocksThatWereLost) {
  for (const auto& stamp : {exact, in_milliseconds}) {
    // one, two that follow each other, one soon after, and one near the end
    const std::vector<StampGap> gaps = gaps_between(blocks({30, 100, 101, 104, 396}, stamp));
    ASSERT_EQ(gaps.size(), 4U);
    const std::vector<std::pair<int, int>> expected{{30, 1}, {99, 2}, {101, 1}, {392, 1}};  // blocks before, lost
    for (std::size_t k = 0; k < gaps.size(); ++k) {
      EXPECT_NEAR(gaps[k].after_s, kBlock_s * expected[k].first, 1e-9) << k;
      EXPECT_NEAR(gaps[k].length_s(), kBlock_s * expected[k].second, 1e-9) << k;  // whole blocks, in spite of rounding
    }
  }
}

TEST(StampGaps, AreNotMadeOfJitterRoundingOrDrift) {
  Random random(1, RandomStream::test, 0);
  EXPECT_TRUE(gaps_between(blocks({}, exact)).empty());
  EXPECT_TRUE(gaps_between(blocks({}, in_milliseconds)).empty());
  EXPECT_TRUE(gaps_between(blocks({}, [&](double t) { return t + 0.01 * random.uniform(); })).empty());
  EXPECT_TRUE(gaps_between(blocks({}, [](double t) { return 1.0005 * t; })).empty());  // 500 ppm
  EXPECT_TRUE(gaps_between({}).empty());
  EXPECT_TRUE(gaps_between({{0.0, kBlock_s}}).empty());
}

TEST(StampGaps, OfStampsThatGoBackAreOverlaps) {
  const std::vector<StampGap> gaps = gaps_between(blocks({}, [](double t) { return t < 2.0 ? t : t - 0.1; }));
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_NEAR(gaps[0].length_s(), -0.1, 1e-9);
  SoundInfo info;
  say_gaps(gaps, info);
  EXPECT_TRUE(info.silences.empty());
  EXPECT_NE(info.warning.find("0.1 s of sound overlap"), std::string::npos) << info.warning;
}

TEST(StampGaps, AJumpOfTheClockIsAMinuteOfSilenceAndSaidWithItsLength) {
  // an hour, ten years; and back to the begin, as where two files were joined
  for (const double jump_s : {3600.0, 3.2e8, -2.0}) {
    const std::vector<StampGap> gaps = gaps_between(blocks({}, [&](double t) { return t < 3.0 ? t : t + jump_s; }));
    ASSERT_EQ(gaps.size(), 1U);
    EXPECT_NEAR(gaps[0].stamped_s, jump_s, 0.5 * kBlock_s);  // to a block
    SoundInfo info;
    say_gaps(gaps, info);
    ASSERT_EQ(info.silences.size(), 1U);
    EXPECT_EQ(info.silences[0].end_s - info.silences[0].begin_s, 60.0);
    EXPECT_NE(info.warning.find(formatted("jump by %.0f s at 3.0", jump_s)), std::string::npos) << info.warning;
    EXPECT_EQ(info.warning.find("its times are kept"), std::string::npos) << info.warning;
  }
}

TEST(StampGaps, SilencesLieWhereTheClockSays) {
  SoundInfo info;
  say_gaps({{1.0, 0.5}, {2.0, 0.25}}, info);
  ASSERT_EQ(info.silences.size(), 2U);
  EXPECT_EQ(info.silences[1].begin_s, 2.5);  // after 2 s of samples and the first gap
  EXPECT_EQ(info.silences[1].end_s, 2.75);
}

}  // namespace
}  // namespace bouncelab::audio
