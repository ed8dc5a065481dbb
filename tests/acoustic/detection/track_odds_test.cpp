// SPDX-License-Identifier: GPL-3.0-or-later
// Log odds of given rows of candidates: that of a ball against a rhythm, of overlapping tracks, of few drops in an
// hour.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/tracker.hpp"

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

TEST(Hypothesis, ABallIsABallAndARhythmNone) {
  const auto followed_by = [](std::vector<Candidate> row, const std::vector<double>& intervals_s, double amplitude) {
    double t_s = row.back().t_s;
    for (const double interval_s : intervals_s) row.push_back(test::candidate(t_s += interval_s, amplitude));
    return row;
  };
  std::vector<double> faster_s(20, 0.25);
  faster_s.resize(40, 0.125);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Hypothesis ball = all_of(test::candidates_of(uneven_ball(), Random(seed, RandomStream::test, 2)));
    EXPECT_FALSE(is_rhythm(ball));
    EXPECT_GT(ball.log_odds_of_ball(), 8.0);
    const Hypothesis metronome = all_of(row_of({.beat_scatter = 1e-3}, seed));
    EXPECT_TRUE(is_rhythm(metronome));
    EXPECT_LT(metronome.log_odds_of_ball(), -8.0);
    const Hypothesis accelerando = all_of(row_of({.factor = 0.97, .interval_scatter = 0.03}, seed));
    EXPECT_TRUE(is_rhythm(accelerando));
    EXPECT_LT(accelerando.log_odds_of_ball(), -2.0);  // fast balls lose as little
    // clutter behind an even row, which fits neither, makes no ball of it
    const auto even = row_of({.n = 12, .interval_s = 0.9, .beat_scatter = 1e-3}, seed);
    EXPECT_LT(all_of(followed_by(even, {0.78, 0.73, 0.69, 0.37, 0.33}, 20.0)).log_odds_of_ball(), -2.0);
    // nor does a row that turns faster have lost on the whole
    const auto row = row_of({.n = 40, .interval_s = 0.5, .beat_scatter = 1e-3}, seed);
    EXPECT_LT(all_of(followed_by(row, faster_s, 100.0)).log_odds_of_ball(), -2.0);
  }
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

Track track_of(const std::vector<std::size_t>& candidates) {
  Track track;
  for (const std::size_t k : candidates) track.impacts.push_back({k, std::ssize(track.impacts)});
  return track;
}

std::vector<Track> rescored_of(const std::vector<Candidate>& candidates, const std::vector<Track>& tracks) {
  return rescored(Observations(candidates, test::kTiming_s, kNone), tracks);
}

std::vector<std::size_t> from_to(std::size_t first, std::size_t last) {
  std::vector<std::size_t> all;
  for (std::size_t k = first; k <= last; ++k) all.push_back(k);
  return all;
}

TEST(Rescoring, OfTracksThatOverlapTheSurestIsKept) {
  // a drop of ten and a triple in which one of its sounds is the last
  const std::vector<Candidate> ball = test::candidates_of({});
  std::vector<Candidate> candidates = test::joined(ball, {test::candidate(0.2, 300.0)});
  const Track whole = track_of(from_to(1, 10)), triple = track_of({0, 1, 3});
  for (const std::vector<Track>& order : {std::vector<Track>{triple, whole}, {whole, triple}}) {
    const std::vector<Track> tracks = rescored_of(candidates, order);
    ASSERT_EQ(tracks.size(), 1u);
    EXPECT_EQ(tracks[0].impacts.back().candidate, 10u);
  }
}

/// Sounds enough for a track in every second of a recording.
std::vector<Candidate> sounds_of(double duration_s) {
  std::vector<Candidate> sounds;
  for (double t_s = 0.1; t_s < duration_s; t_s += 0.5) sounds.push_back({t_s, 100.0, 0.4e-3, 50.0});
  return sounds;
}

/// Log odds of one of n tracks alike.
double weighed(double log_odds, std::size_t n_tracks, double duration_s) {
  std::vector<Track> tracks(n_tracks);
  for (Track& track : tracks) track.log_odds = log_odds;
  weigh_by_drop_rate(sounds_of(duration_s), tracks);
  return tracks.front().log_odds;
}

TEST(DropRate, AChanceRowInAnHourNeedsBetterReasonsThanAClipOfOneDrop) {
  EXPECT_NEAR(weighed(2.0, 1, 3.0), 2.0, 1e-9);
  EXPECT_LT(weighed(3.0, 1, 3600.0), 0.0);
  // the rate is one in the hour at least: no track is asked for more than that
  EXPECT_GT(weighed(3.0, 1, 3600.0), 3.0 - std::log(900.0));
  double last = weighed(3.0, 1, 4.0);
  for (const double duration_s : {40.0, 400.0, 4000.0}) {
    const double now = weighed(3.0, 1, duration_s);
    EXPECT_LT(now, last);
    last = now;
  }
}

TEST(DropRate, ManyDropsSpeakForEachOther) {
  EXPECT_GT(weighed(3.0, 200, 3600.0), weighed(3.0, 20, 3600.0));
  EXPECT_GT(weighed(3.0, 20, 3600.0), weighed(3.0, 1, 3600.0));
  EXPECT_NEAR(weighed(3.0, 300, 3600.0), 3.0, 0.5);  // one in three windows: the largest rate
}

}  // namespace
}  // namespace bouncelab::detection
