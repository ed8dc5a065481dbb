// SPDX-License-Identifier: GPL-3.0-or-later
// What is made of detected onsets: pictures of the sound around them, a copy to listen to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/detection/wave_preview.hpp"

namespace bouncelab::detection {
namespace {

Onsets at(std::initializer_list<double> times_s) {
  Onsets onsets;
  for (const double t : times_s) onsets.push_back({"a", 0, 0, t, {}, {}, {}, {}});
  return onsets;
}

TEST(WavePreview, KeepsTheExtremesOfEverySampleInItsColumn) {
  std::vector<float> x(100003, 0.0F);
  x[50000] = 0.9F;
  x[70001] = -0.8F;
  const WavePreview p = wave_preview(audio::source_in_memory(x, 1e5), "x", 0, {});
  ASSERT_EQ(p.hi.size(), p.lo.size());
  ASSERT_LE(p.hi.size(), 2000U);
  const auto highest = std::max_element(p.hi.begin(), p.hi.end());
  const auto lowest = std::min_element(p.lo.begin(), p.lo.end());
  EXPECT_FLOAT_EQ(static_cast<float>(*highest), 0.9F);
  EXPECT_FLOAT_EQ(static_cast<float>(*lowest), -0.8F);
  // a column is 0.5 ms wide: its centre is within half of that of the sample
  EXPECT_NEAR(p.column_t_s[static_cast<std::size_t>(highest - p.hi.begin())], 0.5, 0.25e-3);
  EXPECT_NEAR(p.column_t_s[static_cast<std::size_t>(lowest - p.lo.begin())], 0.70001, 0.25e-3);
}

TEST(WavePreview, ShowsMarksInTheirExcerptsAndCutsAtTheEnds) {
  const std::vector<float> x(10000, 0.1F);
  Onsets onsets;
  for (const double t_s : {0.001, 0.05, 0.0525, 0.099}) {
    Onset onset;
    onset.recording = "x";
    onset.impact = static_cast<std::int64_t>(onsets.size());
    onset.t_s = t_s;
    onsets.push_back(onset);
  }
  onsets.push_back(onsets.back());
  onsets.back().recording = "another";
  const WavePreview p = wave_preview(audio::source_in_memory(x, 1e5), "x", 0, onsets);
  EXPECT_EQ(p.marks.size(), 4U);
  ASSERT_EQ(p.excerpts.size(), 4U);
  EXPECT_EQ(p.excerpts[0].t0_s, 0.0);
  EXPECT_EQ(p.excerpts[0].samples.size(), 900U);  // 0 to 9 ms: 8 ms after the impact at 1 ms
  EXPECT_EQ(p.excerpts[1].marks.size(), 2U);      // 2.5 ms apart
  EXPECT_EQ(p.excerpts[3].samples.size(), 400U);  // 3 ms before the impact to the end, 1 ms after it
}

TEST(WavePreview, OfOneDropShowsItsStretchAlone) {
  std::vector<float> x(400000, 0.0F);
  x[150000] = 0.5F;  // at 1.5 s, within drop 1
  x[350000] = 0.9F;  // at 3.5 s, in no drop
  Onsets onsets;
  for (const double t_s : {0.1, 0.2, 1.0, 1.5, 2.0}) {
    Onset onset;
    onset.recording = "x";
    onset.drop = t_s < 0.5 ? 0 : 1;
    onset.t_s = t_s;
    onsets.push_back(onset);
  }
  const audio::AudioSource sound = audio::source_in_memory(x, 1e5);
  const WavePreview p = drop_preview(sound, "x", 0, onsets, 1);
  EXPECT_EQ(p.marks.size(), 3U);
  EXPECT_NEAR(p.column_t_s.front(), 0.9,
              1e-3);  // a tenth of the second that the drop lasts before it; a column is .6 ms
  EXPECT_NEAR(p.column_t_s.back(), 2.1, 1e-3);
  EXPECT_EQ(*std::max_element(p.hi.begin(), p.hi.end()), 0.5F);
  EXPECT_THROW(drop_preview(sound, "x", 0, onsets, 2), InvalidArgument);
}

TEST(ListeningCopy, BeginsHalfASecondBeforeTheFirstMarkAndKeepsTimesAndPeak) {
  std::vector<float> x(96000, 0.0F);
  for (std::size_t k = 48000; k < 48400; ++k) x[k] = -0.25F;
  const ListeningCopy copy = listening_copy(audio::source_in_memory(x, 24000.0), at({2.0, 3.0}));
  EXPECT_EQ(copy.rate_hz, 24000.0);
  EXPECT_EQ(copy.t0_s, 1.5);
  EXPECT_EQ(copy.samples.size(), 48000U);  // 1.5 to 3.5 s
  const auto first = std::find_if(copy.samples.begin(), copy.samples.end(), [](std::int16_t s) { return s != 0; });
  EXPECT_EQ(first - copy.samples.begin(), 12000);  // of the sound at 2 s
  EXPECT_EQ(*first, -29490);                       // 0.9 of full scale
}

TEST(ListeningCopy, IsAtMostHalfAMinuteAndOfALowerRate) {
  std::vector<float> x(192000 * 2, 0.1F);
  x.back() = 0.2F;
  EXPECT_EQ(listening_copy(audio::source_in_memory(x, 192000.0), at({1.0})).rate_hz, 24000.0);
  const std::vector<float> slow(100000, 0.1F);  // 100 s
  EXPECT_EQ(listening_copy(audio::source_in_memory(slow, 1000.0), at({10.0, 90.0})).samples.size(), 30000U);
}

TEST(ListeningCopy, IsEmptyWithoutMarksOrSound) {
  const std::vector<float> x(1000, 0.0F);
  EXPECT_TRUE(listening_copy(audio::source_in_memory(x, 1000.0), {}).samples.empty());
  EXPECT_TRUE(listening_copy(audio::source_in_memory(x, 1000.0), at({0.5})).samples.empty());
}

}  // namespace
}  // namespace bouncelab::detection
