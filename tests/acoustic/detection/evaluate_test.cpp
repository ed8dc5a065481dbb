// SPDX-License-Identifier: GPL-3.0-or-later
// What is made of detected onsets: a score against true ones, pictures of the sound around them, a copy to listen to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/detection/wave_preview.hpp"

namespace bouncelab::detection {
namespace {

Onsets at(std::initializer_list<double> times_s, const std::string& recording = "a") {
  Onsets onsets;
  for (const double t : times_s) onsets.push_back({recording, 0, 0, t, {}, {}, {}, {}});
  return onsets;
}

TEST(Score, CountsFoundMissedAndInvented) {
  const OnsetScore score = score_onsets(at({1.0, 2.0, 3.0}), at({1.0001, 2.5, 3.0001, 4.0}));
  EXPECT_EQ(score.n_found, 2u);
  EXPECT_EQ(score.n_missed, 1u);
  EXPECT_EQ(score.n_invented, 2u);
  EXPECT_FALSE(score.match[1].has_value());
}

TEST(Score, AConstantLatencyIsReportedAndTakenOut) {
  const OnsetScore score = score_onsets(at({1.0, 2.0, 3.0}), at({1.0002, 2.0002, 3.0002}));
  EXPECT_NEAR(*score.offset_s, 2e-4, 1e-15);  // rounding of numbers near 3
  EXPECT_NEAR(*score.rms_s, 0.0, 1e-15);
}

TEST(Score, EachDropsOwnLatencyIsTakenOutOfWhatIntervalsSee) {
  Onsets truth = at({1.0, 2.0, 3.0, 4.0});
  truth[2].drop = truth[3].drop = 1;
  const OnsetScore score = score_onsets(truth, at({1.0001, 2.0001, 2.9999, 3.9999}));
  EXPECT_NEAR(*score.rms_s, 1e-4, 1e-15);  // rounding of numbers near 4
  EXPECT_NEAR(*score.rms_within_drops_s, 0.0, 1e-15);
}

TEST(Score, MatchesAreOneToOneNearestFirst) {
  const OnsetScore score = score_onsets(at({1.0, 1.0008}), at({1.0007}));
  EXPECT_EQ(score.n_found, 1u);
  EXPECT_TRUE(score.match[1].has_value());
}

TEST(Score, RecordingsDoNotMix) {
  Onsets truth = at({1.0}, "a");
  EXPECT_EQ(score_onsets(truth, at({1.0}, "b")).n_found, 0u);
}

TEST(Score, PullsComeFromStatedSigmasOnly) {
  Onsets detected = at({1.00000, 2.00002, 2.99998});
  EXPECT_FALSE(score_onsets(at({1, 2, 3}), detected).pull_sd.has_value());
  for (Onset& onset : detected) onset.sigma_t_s = 1e-5;
  // 0, 2 and -2 sigma about their mean: chi2 = 8 of two that are free
  EXPECT_NEAR(*score_onsets(at({1, 2, 3}), detected).pull_sd, 2.0, 1e-9);
}

TEST(Score, AnImpactKnownBetterIsNotChargedWithTheOthersErrors) {
  Onsets detected = at({1.0, 2.00003, 3.00003});
  detected[0].sigma_t_s = 1e-7;
  detected[1].sigma_t_s = detected[2].sigma_t_s = 3e-5;
  // the mean is the first's: 0, 1 and 1 sigma
  EXPECT_NEAR(*score_onsets(at({1, 2, 3}), detected).pull_sd, 1.0, 1e-4);
}

TEST(Score, AnErrorOfTheContactLawIsNoPull) {
  // twenty impacts late by 5 us v^(-1/5), stated to 10 ns: no interval sees more than 20 ns of it
  Onsets truth, detected;
  double t_s = 1.0;
  double flight_s = 0.27;
  for (int k = 0; k < 20; ++k) {
    Onset onset;
    onset.impact = k;
    onset.t_s = t_s;
    truth.push_back(onset);
    onset.t_s += 5e-6 * std::pow(0.5 * 9.81 * (k == 0 ? 0.27 : flight_s), -0.2);
    onset.sigma_t_s = 1e-8;
    detected.push_back(onset);
    if (k > 0) flight_s *= 0.96;
    t_s += flight_s;
  }
  EXPECT_NEAR(*score_onsets(truth, detected).pull_sd, 0.0, 0.01);  // the first has the second's speed
}

TEST(Score, NothingFoundIsNoNumber) {
  const OnsetScore score = score_onsets(at({1.0}), {});
  EXPECT_FALSE(score.rms_s.has_value());
  EXPECT_EQ(score.n_missed, 1u);
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
