// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/hypothesis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "extended.hpp"

namespace bouncelab::detection {
namespace {

const SameSource kNone;

bool is_rhythm(const Hypothesis& h) { return h.log_odds_of_rhythm() > h.log_odds_of_losing_ball(); }

/// That all candidates are the impacts of one ball, their own sounds no clutter.
Hypothesis all_of(const std::vector<Candidate>& candidates) {
  const Observations o(candidates, test::kTiming_s, kNone);
  std::vector<std::size_t> own;
  for (std::size_t k = 0; k < candidates.size(); ++k) own.push_back(k);
  Hypothesis h = Hypothesis::begin(o.without(0, own), o.without(1, own), 1.0, false);
  for (std::size_t k = 2; k < candidates.size(); ++k) {
    const std::optional<Hypothesis> longer = test::extended(h, o.without(k, own), 0, 1.0, false);
    EXPECT_TRUE(longer) << "impact " << k;
    if (!longer) return h;
    h = *longer;
  }
  return h;
}

/// A row of sounds whose intervals change by a factor and scatter, as sounds do about their beats or as intervals do.
struct Row {
  int n = 20;
  double interval_s = 0.35;
  double factor = 1.0;
  double beat_scatter = 0.0, interval_scatter = 0.0;
};

std::vector<Candidate> row_of(const Row& row, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 0);
  std::vector<Candidate> candidates;
  double t_s = 1.0, interval_s = row.interval_s;
  for (int k = 0; k < row.n; ++k) {
    const double off_s = row.beat_scatter * interval_s * random.normal();
    candidates.push_back(test::candidate(t_s + off_s, 200.0 * std::exp(0.15 * random.normal())));
    t_s += interval_s * std::exp(row.interval_scatter * random.normal());
    interval_s *= row.factor;
  }
  return candidates;
}

test::BallRow uneven_ball() { return {.n_impacts = 12, .eps_scatter = 0.015, .loudness_scatter = 0.2}; }

TEST(Hypothesis, NeitherWhenItWasNorTheGainOfTheRecordingMatters) {
  // not at the begin of the recording, where less of it is around
  const std::vector<Candidate> ball =
      test::shifted(test::candidates_of(uneven_ball(), Random(1, RandomStream::test, 1)), kLargestReach_s, 1.0);
  const Hypothesis here = all_of(ball);
  for (const double gain : {1e-6, 1.0, 1e6})
    for (const double by_s : {0.0, 1e5}) {
      const Hypothesis there = all_of(test::shifted(ball, by_s, gain));
      // times of a day are rounded to 1.5e-11 s, a 1e-7 of the errors
      EXPECT_NEAR(there.log_odds, here.log_odds, 1e-4) << gain << " " << by_s;
      EXPECT_NEAR(there.log_odds_of_ball(), here.log_odds_of_ball(), 1e-4) << gain << " " << by_s;
      EXPECT_NEAR(there.log_odds_of_rhythm(), here.log_odds_of_rhythm(), 1e-4);
    }
}

TEST(Hypothesis, ABallIsABall) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Hypothesis h = all_of(test::candidates_of(uneven_ball(), Random(seed, RandomStream::test, 2)));
    EXPECT_FALSE(is_rhythm(h)) << seed;
    EXPECT_GT(h.log_odds_of_ball(), 8.0) << seed;
  }
}

TEST(Hypothesis, AMetronomeIsARhythm) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Hypothesis h = all_of(row_of({.beat_scatter = 1e-3}, seed));
    EXPECT_TRUE(is_rhythm(h)) << seed;
    EXPECT_LT(h.log_odds_of_ball(), -8.0) << seed;
  }
}

TEST(Hypothesis, AnAccelerandoByHandIsARhythm) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Hypothesis h = all_of(row_of({.factor = 0.97, .interval_scatter = 0.03}, seed));
    EXPECT_TRUE(is_rhythm(h)) << seed;
    EXPECT_LT(h.log_odds_of_ball(), -2.0) << seed;  // fast balls lose as little
  }
}

TEST(Hypothesis, AnEvenRowIsNoBallForTheClutterThatFollows) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<Candidate> both = row_of({.n = 12, .interval_s = 0.9, .beat_scatter = 1e-3}, seed);
    double t_s = both.back().t_s;
    for (const double interval_s : {0.78, 0.73, 0.69, 0.37, 0.33})  // which neither fits
      both.push_back(test::candidate(t_s += interval_s, 20.0));
    EXPECT_LT(all_of(both).log_odds_of_ball(), -2.0) << seed;
  }
}

TEST(Hypothesis, ARowThatTurnsFasterIsNoBallForHavingLostOnTheWhole) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<Candidate> both = row_of({.n = 40, .interval_s = 0.5, .beat_scatter = 1e-3}, seed);
    double t_s = both.back().t_s;
    for (int k = 0; k < 40; ++k) both.push_back(test::candidate(t_s += k < 20 ? 0.25 : 0.125, 100.0));
    EXPECT_LT(all_of(both).log_odds_of_ball(), -2.0) << seed;
    EXPECT_TRUE(is_rhythm(all_of(both))) << seed;
  }
}

TEST(Hypothesis, AMissedImpactCostsItsProbability) {
  const std::vector<Candidate> ball = test::candidates_of({});
  std::vector<Candidate> with_gap = ball;
  with_gap.erase(with_gap.begin() + 5);
  const Observations o(with_gap, test::kTiming_s, kNone);
  Hypothesis h = Hypothesis::begin(o[0], o[1], 1.0, true);
  for (std::size_t k = 2; k < 5; ++k) h = test::extended(h, o[k], 0, 1.0, true).value();
  const Hypothesis next = test::extended(h, o[5], 1, 1.0, true).value();
  EXPECT_EQ(next.impact, 6);
  EXPECT_EQ(next.n_impacts, 6);
  EXPECT_GT(next.log_odds, h.log_odds);
  // and what follows directly would be a gain of eps above its limit
  EXPECT_FALSE(test::extended(h, o[5], 0, 1.0, true));
}

TEST(Hypothesis, BelowTheLeastLogOddsIsNoHypothesis) {
  const std::vector<Candidate> ball = test::candidates_of({});
  const Observations o(ball, test::kTiming_s, kNone);
  const Hypothesis h = Hypothesis::begin(o[0], o[1], 1.0, true);
  const double odds = test::extended(h, o[2], 0, 1.0, true)->log_odds;
  EXPECT_TRUE(test::extended(h, o[2], 0, 1.0, true, odds - 1e-9));
  EXPECT_FALSE(test::extended(h, o[2], 0, 1.0, true, odds + 1e-9));
}

TEST(Hypothesis, ASoundOfAnotherSourceIsAWorseImpact) {
  const std::vector<Candidate> ball = test::candidates_of({});
  const Observations o(ball, test::kTiming_s, kNone);
  EXPECT_LT(Hypothesis::begin(o[0], o[1], 0.1, true).log_odds, Hypothesis::begin(o[0], o[1], 1.0, true).log_odds - 1.0);
}

TEST(Hypothesis, LogOddsOfAThousandImpactsDoNotOverflow) {
  // steel on glass; 0.5 to 0.068 s
  std::vector<Candidate> ball = test::candidates_of({.eps = 0.998, .n_impacts = 1000});
  double last = 0.0;
  for (const int n : {100, 300, 1000}) {
    const Hypothesis h = all_of({ball.begin(), ball.begin() + n});
    EXPECT_EQ(h.n_impacts, n);
    EXPECT_TRUE(std::isfinite(h.log_odds_of_ball()));
    EXPECT_TRUE(std::isfinite(h.log_odds_of_rhythm()));
    EXPECT_GT(h.log_odds, last + 100.0);
    last = h.log_odds;
  }
  for (Candidate& c : ball) c.t_s = 1.0 + 0.3 * static_cast<double>(&c - ball.data());  // and of a clock
  const Hypothesis clock = all_of(ball);
  EXPECT_TRUE(std::isfinite(clock.log_odds_of_ball()));
  EXPECT_LT(clock.log_odds_of_ball(), -100.0);
}

TEST(Hypothesis, OddsOfAnImpactBeforeAreBestWhereTheBallWouldHaveBeen) {
  const std::vector<Candidate> ball = test::candidates_of({});
  const double flight_s = ball[2].t_s - ball[1].t_s;
  const auto odds_at = [&](double off) {
    std::vector<Candidate> moved = ball;
    moved[0].t_s += off * (ball[1].t_s - ball[0].t_s);
    const Observations o(moved, test::kTiming_s, kNone);
    const std::vector<std::size_t> own{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    return log_odds_before(o.without(0, own), o[1], 1.0, flight_s, std::log(0.8), 0.01);
  };
  EXPECT_GT(odds_at(0.0), 0.0);
  EXPECT_GT(odds_at(0.0), odds_at(0.05));
  EXPECT_GT(odds_at(0.05), odds_at(0.3));
}

}  // namespace
}  // namespace bouncelab::detection
