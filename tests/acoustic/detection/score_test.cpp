// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/score.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace bouncelab::detection
