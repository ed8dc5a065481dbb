// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/observations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kInWindow = 18.0;  // samples of 0.4 ms at 44.1 kHz

struct Scene {
  std::vector<Candidate> candidates;
  std::vector<bool> is_event;
};

/// Candidates 20 ms apart as the model has them.
Scene scene(int n, double share_of_events, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 0);
  Scene s;
  const double z0 = kTracking.event_per_sample * kInWindow;
  const double excess = kTracking.excess + kTracking.excess_per_sample * kInWindow;
  for (int k = 0; k < n; ++k) {
    s.is_event.push_back(random.uniform() < share_of_events);
    const double u = random.uniform();
    const double z = s.is_event.back() ? z0 * u / (1.0 - u) : excess * random.exponential();
    s.candidates.push_back(test::candidate(0.02 * k, 100.0, kCandidates.threshold + z));
  }
  return s;
}

std::vector<double> odds_of(const Scene& s) { return log_rise_odds(s.candidates, kInWindow); }

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(RiseOdds, ProbabilitiesSumToTheNumberOfEvents) {
  for (const double share : {0.2, 0.5, 0.8}) {
    const Scene s = scene(8000, share, 1);
    double expected = 0.0, n_events = 0.0;
    const std::vector<double> odds = odds_of(s);
    for (std::size_t k = 0; k < odds.size(); ++k) {
      expected += share * std::exp(odds[k]);  // probability of an event, given its rise
      n_events += s.is_event[k] ? 1.0 : 0.0;
    }
    // the share is estimated from 48 neighbours and a prior of one half
    EXPECT_NEAR(expected / n_events, 1.0, 0.15) << share;
  }
}

TEST(RiseOdds, FluctuationsAloneHaveLowOdds) {
  const std::vector<double> odds = odds_of(scene(300, 0.0, 2));
  EXPECT_LT(mean(odds), -0.5);
  const auto n_high = std::count_if(odds.begin(), odds.end(), [](double each) { return each > 1.0; });
  EXPECT_LT(n_high, 30);  // one in ten by chance at most: that is what odds of e are
}

TEST(RiseOdds, EventsAmongEventsNeitherGainNorLose) {
  for (const double each : odds_of(scene(300, 1.0, 3))) EXPECT_LT(each, 0.7);  // log(1 / share), the prior counted
  EXPECT_NEAR(mean(odds_of(scene(300, 1.0, 3))), 0.0, 0.3);
}

TEST(RiseOdds, AnEventStandsOutWhereFluctuationsAreMany) {
  Scene s = scene(60, 0.0, 4);
  s.candidates[30].log_likelihood_ratio = 200.0;
  const std::vector<double> odds = odds_of(s);
  EXPECT_GT(odds[30], 1.0);
  for (std::size_t k = 0; k < odds.size(); ++k) {
    if (k == 30) continue;
    EXPECT_LT(odds[k], odds[30]) << k;
  }
}

TEST(RiseOdds, GrowWithTheRise) {
  Scene s = scene(40, 0.3, 5);
  double last = -100.0;
  for (const double llr : {8.0, 12.0, 20.0, 50.0, 1000.0}) {
    s.candidates[20].log_likelihood_ratio = llr;
    const double here = odds_of(s)[20];
    EXPECT_GE(here, last - 1e-12) << llr;
    last = here;
  }
}

TEST(RiseOdds, ACandidateAloneHasThePriorShare) {
  // p(LLR | event) / p(LLR) with one half: between nothing and log 2
  EXPECT_NEAR(log_rise_odds({test::candidate(1.0, 100.0, 1e4)}, kInWindow)[0], std::log(2.0), 1e-6);
  EXPECT_LT(log_rise_odds({test::candidate(1.0, 100.0, kCandidates.threshold)}, kInWindow)[0], 0.0);
}

TEST(RiseOdds, WhatIsFurtherThanASecondDoesNotMatter) {
  Scene s = scene(40, 0.0, 6);
  s.candidates.push_back(test::candidate(10.0, 100.0, 30.0));
  const double among_others = odds_of(s).back();
  EXPECT_EQ(among_others, log_rise_odds({s.candidates.back()}, kInWindow)[0]);
}

}  // namespace
}  // namespace bouncelab::detection
