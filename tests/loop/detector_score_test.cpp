// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/detector_score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"

namespace bouncelab::loop {
namespace {

Onsets at(const std::vector<double>& times_s) {
  Onsets onsets;
  for (const double t : times_s) {
    onsets.emplace_back().t_s = t;
    onsets.back().impact = static_cast<std::int64_t>(onsets.size()) - 1;
  }
  return onsets;
}

constexpr double kExact = 1e-12;  // of sums of a few doubles below 10

TEST(DetectorScore, CountsPairsWithin50MillisecondsAsMirEvalDoes) {
  // by hand: 0.97 takes 1.015 and 1.01 takes 1.055, 45 ms each, where nearest first would join 1.01 and 1.015 and leave
  // 0.97 alone; 2.0 has two marks; 3.0 has one 51 ms off
  const DetectorScore score =
      score_detector({at({0.97, 1.01, 2.0, 3.0})}, at({1.015, 1.055, 1.99, 2.01, 3.051}), 4.0, 0.0);
  EXPECT_EQ(score.agreement[0].n_found, 3U);
  EXPECT_NEAR(*score.agreement[0].precision(), 3.0 / 5.0, kExact);
  EXPECT_NEAR(*score.agreement[0].recall(), 3.0 / 4.0, kExact);
  EXPECT_NEAR(*score.agreement[0].f_measure(), 6.0 / 9.0, kExact);
}

TEST(DetectorScore, IsAsGoodWithALatencyAsWithout) {
  // latency 20 ms; errors about it: 0, +0.2, -0.2, 0 and one of 3 ms
  const std::vector<double> truth{1.0, 1.5, 1.9, 2.2, 2.4};
  const DetectorScore score = score_detector({at(truth)}, at({1.02, 1.5202, 1.9198, 2.22, 2.423}), 4.0, 0.0);
  ASSERT_TRUE(score.offset_s);
  EXPECT_NEAR(*score.offset_s, 0.02, kExact);
  EXPECT_EQ(score.agreement[1].n_found, 5U);  // 5 ms
  EXPECT_EQ(score.agreement[2].n_found, 4U);  // 1 ms
  EXPECT_EQ(score.agreement[3].n_found, 2U);  // 0.1 ms
  EXPECT_NEAR(*score.jitter_s, std::sqrt((2.0 * 0.2e-3 * 0.2e-3 + 3e-3 * 3e-3) / 5.0), kExact) << "as recall at 5 ms";
  EXPECT_NEAR(*score.typical_s, 1.4826 * 0.2e-3, kExact);
  // eps of (1.0, 1.5, 1.9), (1.5, 1.9, 2.2) and (1.9, 2.2, 2.4), by hand
  const double first = 0.3996 / 0.5002 - 0.8, second = 0.3002 / 0.3996 - 0.75, third = 0.203 / 0.3002 - 2.0 / 3.0;
  EXPECT_NEAR(*score.eps_error, std::sqrt((first * first + second * second + third * third) / 3.0), kExact);
}

TEST(DetectorScore, PairsAreOneToOneTheNearestFirstInWhateverOrder) {
  const DetectorScore score = score_detector({at({2.0, 1.0, 1.0008})}, at({2.0, 3.0, 1.0007}), 4.0, 0.0);
  const std::vector<std::optional<std::size_t>> match{0, {}, 2};
  EXPECT_EQ(score.agreement[0].n_found, 2U);
  EXPECT_EQ(score.match, match);
  EXPECT_EQ(pooled({score, score}).match, (std::vector<std::optional<std::size_t>>{0, {}, 2, 3, {}, 5}));
}

TEST(DetectorScore, EachDropsOwnLatencyIsTakenOutOfWhatIntervalsSee) {
  Onsets truth = at({1.0, 2.0, 3.0, 4.0});
  truth[2].drop = truth[3].drop = 1;
  const DetectorScore score = score_detector({truth}, at({1.0001, 2.0001, 2.9999, 3.9999}), 5.0, 0.0);
  EXPECT_NEAR(*score.jitter_s, 1e-4, kExact);
  EXPECT_NEAR(*score.within_drops_s, 0.0, kExact);
  EXPECT_FALSE(score.pull());  // nothing is stated
}

TEST(DetectorScore, HasMoreJitterWhereThereIsMoreNoise) {
  Random random(9, RandomStream::test, 0);
  Onsets truth;
  for (int k = 0; k < 2000; ++k) truth.emplace_back().t_s = 0.1 * k;
  const auto score_of_noise = [&](double sigma_s) {
    Onsets marks = truth;
    for (Onset& mark : marks) mark.t_s += sigma_s * random.normal();
    return score_detector({truth}, marks, 200.0, 0.0);
  };
  // a normal distribution cut at 5 ms; three errors of a standard deviation from 1000 numbers are 7 %
  for (const auto& [sigma_s, jitter_s] : {std::pair(1e-3, 1e-3), {3e-3, 2.39e-3}, {10e-3, 2.84e-3}})
    EXPECT_NEAR(*score_of_noise(sigma_s).jitter_s / jitter_s, 1.0, 0.07) << sigma_s;
  EXPECT_NEAR(*score_of_noise(10e-3).agreement[1].recall(), std::erf(0.5 / std::sqrt(2.0)), 0.035) << "is beside it";
}

TEST(DetectorScore, HasNoJitterOfPairsThroughWhichItsConstantsPass) {
  const DetectorScore two = score_detector({at({1.0, 1.5, 1.9})}, at({1.01, 1.5104}), 3.0, 0.0);
  EXPECT_TRUE(two.offset_s);
  for (const auto& value : {two.jitter_s, two.typical_s, two.within_drops_s}) EXPECT_FALSE(value);
  Onsets truth = at({1.0, 2.0, 3.0});  // one of each of three drops: each has its own latency
  for (std::size_t k = 0; k < 3; ++k) truth[k].drop = static_cast<std::int64_t>(k);
  const DetectorScore apart = score_detector({truth}, at({1.0, 2.001, 3.0}), 4.0, 0.0);
  EXPECT_TRUE(apart.jitter_s);
  EXPECT_FALSE(apart.within_drops_s);
}

TEST(DetectorScore, SeesTheBoundBehindTheContactLaw) {
  // errors 2 us from a normal distribution about 5 us v^(-1/5): the ratio to a bound of 2 us is 1 within the error of a
  // standard deviation from 2000 numbers, 1/sqrt(4000) = 1.6 %, of which three are allowed
  Random random(7, RandomStream::test, 0);
  TrueTimes truth;
  Onsets marks;
  for (int k = 0; k < 2000; ++k) {
    Onset onset;
    onset.t_s = 0.1 * k;
    onset.sigma_t_s = 2e-6;
    truth.onsets.push_back(onset);
    truth.v_mps.push_back(random.uniform(0.05, 1.4));
    onset.t_s += 1e-3 + 100e-6 * std::pow(truth.v_mps.back(), -0.2) + 2e-6 * random.normal();
    marks.push_back(onset);
  }
  const DetectorScore score = score_detector(truth, marks, 200.0, 2.0);
  EXPECT_NEAR(*score.bound_ratio, 1.0, 0.05);
  EXPECT_NEAR(*score.pull(), 1.0, 0.05);
  EXPECT_NEAR(*score.coverage(), 0.95, 3.0 * std::sqrt(0.95 * 0.05 / 1000.0));  // neighbours share a mark
  EXPECT_NEAR(*score.times_real_time(), 100.0, kExact);
  EXPECT_LT(*score.largest_pull, 5.0);  // of 1999 normal errors one in 900 runs has a larger one
  const double pull_before = *score.pull();
  marks[1000].t_s += 100e-6;  // 50 standard errors, 35 of an interval
  const DetectorScore wrong = score_detector(truth, marks, 200.0, 2.0);
  EXPECT_NEAR(*wrong.largest_pull, 50.0 / std::sqrt(2.0), 5.0);
  EXPECT_LT(*wrong.pull(), pull_before + 0.5);  // sqrt(1 + 2 35^2/1999): two of 1999 are seen in the largest
  EXPECT_EQ(*pooled({score, wrong}).largest_pull, *wrong.largest_pull);
  marks[1000].t_s -= 100e-6;
  truth.v_mps.clear();
  EXPECT_GT(*score_detector(truth, marks, 200.0, 2.0).bound_ratio, 5.0);
}

TEST(DetectorScore, HasIntervalsOfEachBallWhereTwoBounce) {
  Onsets truth = at({1.0, 1.1, 1.5, 1.55, 1.9, 1.8});
  for (std::size_t k = 0; k < truth.size(); ++k) truth[k].drop = static_cast<std::int64_t>(k % 2);
  Onsets marks = truth;
  std::sort(marks.begin(), marks.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  const DetectorScore score = score_detector({truth}, marks, 3.0, 0.0);
  EXPECT_EQ(*score.jitter_s, 0.0);
  EXPECT_NEAR(*score.eps_error, 0.0, kExact);
}

TEST(DetectorScore, ScoresStatedErrorsHighestWhereTheyAreTheErrors) {
  Random random(8, RandomStream::test, 0);
  Onsets truth, marks;
  for (int k = 0; k < 1000; ++k) {
    Onset& onset = truth.emplace_back();
    onset.t_s = 0.1 * k;
    marks.push_back(onset);
    marks.back().t_s += 2e-6 * random.normal();
  }
  const auto log_score = [&](double sigma_s) {
    for (Onset& mark : marks) mark.sigma_t_s = sigma_s;
    return *score_detector({truth}, marks, 100.0, 0.0).log_score();
  };
  // -ln(sqrt(2) 2) - 1/2 of intervals between times with errors of 2 us, within three times the error of that mean
  EXPECT_NEAR(log_score(2e-6), -std::log(2.0 * std::sqrt(2.0)) - 0.5, 3.0 / std::sqrt(1000.0));
  for (const double wrong_s : {1e-12, 0.2e-6, 1e-6, 4e-6, 1e-3}) EXPECT_LT(log_score(wrong_s), log_score(2e-6));
}

TEST(DetectorScore, CallsInventedWhatIsMarkedWithoutABall) {
  const DetectorScore score = score_detector({}, at({1.0, 2.0}), 7200.0, 1.0);
  EXPECT_NEAR(*score.invented_per_hour(), 1.0, kExact);
  EXPECT_FALSE(score.agreement[0].recall());
  EXPECT_EQ(*score.agreement[0].precision(), 0.0);
}

TEST(DetectorScore, PoolsCountsAndTakesMediansOfErrors) {
  const std::vector<double> truth{1.0, 1.5, 1.9};
  const DetectorScore good = score_detector({at(truth)}, at(truth), 3.0, 1.0),
                      late = score_detector({at(truth)}, at({1.0101, 1.5099}), 3.0, 1.0),
                      nothing = score_detector({at(truth)}, {}, 3.0, 1.0);
  const DetectorScore all = pooled({good, late, nothing});
  EXPECT_EQ(all.n_recordings, 3U);
  EXPECT_NEAR(*all.agreement[0].recall(), 5.0 / 9.0, kExact);
  EXPECT_NEAR(*all.offset_s, 0.005, kExact);
  EXPECT_NEAR(*all.times_real_time(), 3.0, kExact);
}

}  // namespace
}  // namespace bouncelab::loop
