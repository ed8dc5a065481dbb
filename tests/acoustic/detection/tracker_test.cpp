// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "tracking/hypothesis.hpp"

namespace bouncelab::detection {
namespace {

/// A ping-pong ball as recorded by a phone with gain control: the first two impacts are turned down to a quarter, and
/// other sounds, some as loud, come before.
std::vector<Candidate> turned_down_at_first(std::uint64_t seed, std::vector<double>& impacts_s) {
  Random random(seed, RandomStream::test, 0);
  std::vector<Candidate> candidates;
  const auto add = [&](double t_s, double amplitude) { candidates.push_back({t_s, amplitude, 0.4e-3, 50.0}); };
  for (int k = 0; k < 5; ++k) add(1.8 * random.uniform(), 60.0 * random.uniform());
  double flight_s = 0.19;
  double t_s = 2.1;
  for (int k = 0; k < 30; ++k) {
    impacts_s.push_back(t_s);
    add(t_s, 1000.0 * flight_s * std::exp(0.2 * random.normal()) * (k < 2 ? 0.25 : 1.0));
    t_s += flight_s *= 0.945 * std::exp(0.004 * random.normal());
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  return candidates;
}

TEST(Tracker, BeginWithTheFirstImpactThoughItIsFaint) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<double> impacts_s;
    const std::vector<Candidate> candidates = turned_down_at_first(seed, impacts_s);
    const std::vector<Track> tracks = find_tracks(candidates, 5e-5);
    ASSERT_EQ(tracks.size(), 1u) << seed;
    EXPECT_EQ(candidates[tracks[0].impacts.front().candidate].t_s, impacts_s.front()) << seed;
    EXPECT_EQ(tracks[0].impacts.size(), impacts_s.size()) << seed;
    for (std::size_t k = 0; k < tracks[0].impacts.size(); ++k)
      EXPECT_EQ(tracks[0].impacts[k].impact, static_cast<std::int64_t>(k)) << seed;
  }
}

/// A drop from 0.4 s on each of whose impacts has an echo.
struct EchoingDrop {
  int n_impacts;
  double first_flight_s, eps, eps_rise, eps_scatter;  // the rise from impact to impact
  double echo_s, echo;                                // after the impact, of its amplitude
};

std::vector<Candidate> with_echoes(const EchoingDrop& d, Random random) {
  std::vector<Candidate> candidates;
  double flight_s = d.first_flight_s;
  double t_s = 0.4;
  for (int k = 0; k < d.n_impacts; ++k) {
    const double amplitude = 500.0 * flight_s * std::exp(0.25 * random.normal());
    candidates.push_back({t_s, amplitude, 0.4e-3, 50.0});
    candidates.push_back({t_s + d.echo_s, d.echo * amplitude * std::exp(0.3 * random.normal()), 0.4e-3, 20.0});
    t_s += flight_s;
    flight_s *= (d.eps + d.eps_rise * k) * std::exp(d.eps_scatter * random.normal());
  }
  return candidates;
}

TEST(Tracker, BeginWithTheFirstImpactAndNotWithItsEcho) {
  // eps grows as the ball slows down, so that the interval from the echo on fits the mean of all as well
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const EchoingDrop drop{30, 0.55, 0.905, 0.035 / 29.0, 0.003, 9e-3, 0.5};
    const std::vector<Candidate> candidates = with_echoes(drop, Random(seed, RandomStream::test, 1));
    const std::vector<Track> tracks = find_tracks(candidates, 5e-5);
    ASSERT_EQ(tracks.size(), 1u) << seed;
    EXPECT_EQ(tracks[0].impacts.front().candidate, 0u) << seed;
  }
}

/// The most probable set of tracks by the score of all sequences of candidates, none left out.
class ExhaustiveSearch {
 public:
  /// Tracks that follow each other, and their score. Scores of the same tracks are those of the best of them.
  struct Solution {
    double score = 0.0;
    std::vector<Track> tracks;
  };

  explicit ExhaustiveSearch(const Observations& o) : o_(o), best_(o.size() + 1) {
    best_[0] = {Solution{}};
    for (std::size_t last = 0; last < o.size(); ++last) {
      best_[last + 1] = best_[last];
      here_ = last;
      for (std::size_t j = 0; j < last; ++j)
        for (std::size_t k = j + 1; k <= last; ++k) {
          const double flight_s = o[k].t_s - o[j].t_s;
          if (flight_s < kShortestFirstFlight_s || flight_s > kLongestFlight_s) continue;
          Track track;
          track.impacts = {{j, 0}, {k, 1}};
          follow(Hypothesis::begin(o[j], o[k], o.same_source(j, k), true), track);
        }
    }
  }

  /// The two best, which differ in their tracks.
  const std::vector<Solution>& solutions() const { return best_.back(); }

 private:
  void follow(const Hypothesis& h, const Track& track) {
    const std::size_t last = track.impacts.back().candidate;
    if (last == here_) return take(h, track);
    const int most_missing = h.n_impacts == 2 ? 0 : kMostMissing;
    for (std::size_t k = last + 1; k <= here_; ++k)
      for (int n_missing = 0; n_missing <= most_missing; ++n_missing) {
        const auto longer = test::extended(h, o_[k], n_missing, o_.same_source(last, k), true);
        if (!longer) continue;
        Track more = track;
        more.impacts.push_back({k, longer->impact});
        follow(*longer, more);
      }
  }

  void take(const Hypothesis& h, const Track& track) {
    if (h.n_impacts < kFewestImpacts) return;
    constexpr double kOwnClutter = 5.0;  // nats that may come back when its own sounds are no longer its clutter
    const double ball = h.log_odds_of_losing_ball();
    const double most = std::max(ball, h.log_odds_of_rhythm());
    if (most + kOwnClutter <= 0.0) return;
    for (Solution s : best_[track.impacts.front().candidate]) {
      s.score += std::log1p(std::exp(most));
      if (most == ball) s.tracks.push_back(track);
      keep(s, best_[here_ + 1]);
    }
  }

  static bool are_same(const std::vector<Track>& a, const std::vector<Track>& b) {
    const auto same_impact = [](const TrackImpact& x, const TrackImpact& y) {
      return x.candidate == y.candidate && x.impact == y.impact;
    };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const Track& x, const Track& y) {
      return std::equal(x.impacts.begin(), x.impacts.end(), y.impacts.begin(), y.impacts.end(), same_impact);
    });
  }

  static void keep(const Solution& s, std::vector<Solution>& best) {
    const auto same =
        std::find_if(best.begin(), best.end(), [&](const Solution& other) { return are_same(other.tracks, s.tracks); });
    if (same == best.end())
      best.push_back(s);
    else
      same->score = std::max(same->score, s.score);
    std::stable_sort(best.begin(), best.end(), [](const Solution& a, const Solution& b) { return a.score > b.score; });
    if (best.size() > 2) best.resize(2);
  }

  const Observations& o_;
  std::vector<std::vector<Solution>> best_;  // best_[k]: over candidates before k
  std::size_t here_ = 0;
};

/// A ball of three to seven impacts, some of which may be missing, among other sounds: twelve candidates at most.
std::vector<Candidate> small_scene(std::uint64_t seed) {
  Random random(seed, RandomStream::test, 4);
  test::BallRow ball;
  ball.first_s = random.uniform(0.5, 1.5);
  ball.first_flight_s = random.uniform(0.2, 0.7);
  ball.eps = random.uniform(0.55, 0.95);
  ball.n_impacts = static_cast<int>(random.uniform(3.0, 8.0));
  ball.eps_scatter = random.uniform(0.0, 0.03);
  ball.loudness_scatter = 0.3;
  std::vector<Candidate> candidates = test::candidates_of(ball, Random(seed, RandomStream::test, 5));
  if (random.uniform() < 0.3) candidates.erase(candidates.begin() + std::ssize(candidates) / 2);
  for (auto n = static_cast<int>(random.uniform(0.0, 6.0)); n > 0; --n) {
    const double snr = 150.0 * std::exp(0.7 * random.normal());
    candidates.push_back(test::candidate(random.uniform(0.0, 4.0), snr));
  }
  test::sort_by_time(candidates);
  return candidates;
}

using Places = std::vector<std::vector<std::size_t>>;
Places places_of(const std::vector<Track>& tracks) {
  Places places;
  for (const Track& track : tracks) {
    places.emplace_back();
    for (const TrackImpact& impact : track.impacts) places.back().push_back(impact.candidate);
  }
  return places;
}

TEST(Tracker, SearchFindsWhatAnExhaustiveSearchOverAllSequencesFinds) {
  constexpr double kClear = 0.5;  // log odds of the best against the second
  constexpr std::uint64_t kSeeds = 300;
  int n_clear = 0, n_with_ball = 0, n_at_once = 0;
  const SameSource none;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<Candidate> candidates = small_scene(seed);
    ASSERT_LE(candidates.size(), 12u);
    const Observations o(candidates, test::kTiming_s, none);
    const ExhaustiveSearch all(o);
    const std::vector<ExhaustiveSearch::Solution>& best = all.solutions();
    if (best.size() > 1 && best[0].score < best[1].score + kClear) continue;
    n_clear += 1;
    n_with_ball += best[0].tracks.empty() ? 0 : 1;
    std::vector<Track> expected = rescored(o, best[0].tracks);
    weigh_by_drop_rate(candidates, expected);
    std::erase_if(expected, [](const Track& track) { return track.log_odds < 0.0; });
    const std::vector<Track> found = find_tracks(candidates, test::kTiming_s);
    // balls at once are not among its sequences
    if (found.size() == 2 && found[1].impacts.front().candidate < found[0].impacts.back().candidate) {
      n_at_once += 1;
      continue;
    }
    EXPECT_EQ(places_of(found), places_of(expected)) << seed;
  }
  EXPECT_LE(n_at_once, 1);
  EXPECT_GT(n_clear, 200);
  EXPECT_GT(n_with_ball, 150);
}

TEST(Tracker, NeitherTheTimeNorTheGainOfARecordingMatters) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    // not at the begin of the recording, where less of it is around
    const std::vector<Candidate> candidates = test::shifted(small_scene(seed), kLargestReach_s, 1.0);
    const std::vector<Track> here = find_tracks(candidates, test::kTiming_s);
    const std::vector<Track> there = find_tracks(test::shifted(candidates, 3600.0, 1e-3), test::kTiming_s);
    ASSERT_EQ(places_of(here), places_of(there)) << seed;
    // times of an hour are rounded to 5e-13 s
    for (std::size_t k = 0; k < here.size(); ++k) EXPECT_NEAR(here[k].log_odds, there[k].log_odds, 1e-4) << seed;
  }
}

TEST(Tracker, DropsThatHaveNothingToDoWithEachOtherAreFoundAloneAsTogether) {
  constexpr double kSure = 3.0;    // what is less probable alone may win or lose by the other
  constexpr double kOfRate = 1.1;  // log odds by which two drops may tell of each other's rate, from 1 to 1/3
  const auto sure = [](std::vector<Track> tracks) {
    std::erase_if(tracks, [](const Track& track) { return track.log_odds < kSure; });
    return tracks;
  };
  int n_compared = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<Candidate> first = small_scene(seed);
    const std::vector<Candidate> second = test::shifted(small_scene(seed + 100), 30.0, 1.0);
    std::vector<Track> apart = find_tracks(first, test::kTiming_s);
    for (Track& track : find_tracks(second, test::kTiming_s)) {
      for (TrackImpact& impact : track.impacts) impact.candidate += first.size();
      apart.push_back(track);
    }
    const std::vector<Track> together = find_tracks(test::joined(first, second), test::kTiming_s);
    for (const Track& track : sure(apart)) {
      const auto same = std::find_if(together.begin(), together.end(),
                                     [&](const Track& other) { return places_of({other}) == places_of({track}); });
      ASSERT_NE(same, together.end()) << seed;
      EXPECT_NEAR(same->log_odds, track.log_odds, kOfRate) << seed;
      n_compared += 1;
    }
  }
  EXPECT_GT(n_compared, 15);
}

TEST(Tracker, AMissingImpactIsCountedAndNotClosedUp) {
  std::vector<Candidate> ball = test::candidates_of({});
  ball.erase(ball.begin() + 4);
  const std::vector<Track> tracks = find_tracks(ball, test::kTiming_s);
  ASSERT_EQ(tracks.size(), 1u);
  ASSERT_EQ(tracks[0].impacts.size(), 9u);
  EXPECT_EQ(tracks[0].impacts[3].impact, 3);
  EXPECT_EQ(tracks[0].impacts[4].impact, 5);
  EXPECT_EQ(tracks[0].impacts[8].impact, 9);
}

TEST(Tracker, StatesThatAreNoLongerNeededAreForgottenWithoutALoss) {
  // so many candidates that the states of most are dropped on the way: a drop in each half minute of clutter
  std::vector<Candidate> candidates;
  Random random(1, RandomStream::test, 6);
  constexpr int kDrops = 40;
  for (int drop = 0; drop < kDrops; ++drop) {
    candidates = test::joined(candidates, test::candidates_of({.first_s = 30.0 * drop + 10.0, .n_impacts = 12}));
    for (int k = 0; k < 60; ++k)
      candidates.push_back(test::candidate(30.0 * (drop + random.uniform()), 20.0 * random.uniform()));
  }
  test::sort_by_time(candidates);
  const std::vector<Track> tracks = find_tracks(candidates, test::kTiming_s);
  for (int drop = 0; drop < kDrops; ++drop)  // beside them, chance makes some of few impacts and low odds
    EXPECT_EQ(std::count_if(tracks.begin(), tracks.end(),
                            [&](const Track& track) {
                              const double begin_s = candidates[track.impacts.front().candidate].t_s;
                              return std::abs(begin_s - 30.0 * drop - 10.0) < 1e-9 && track.impacts.size() >= 12;
                            }),
              1)
        << drop;
}

TEST(Tracker, NothingGivesNoTracks) {
  EXPECT_TRUE(find_tracks({}, test::kTiming_s).empty());
  EXPECT_TRUE(find_tracks({test::candidate(1.0, 100.0), test::candidate(1.5, 80.0)}, test::kTiming_s).empty());
}

TEST(Tracker, AHeightSaysHowLongTheFirstFlightMayBe) {
  const auto log_odds = [](const std::vector<Candidate>& candidates, std::optional<double> elastic_flight_s) {
    const std::vector<Track> tracks = find_tracks(candidates, test::kTiming_s, {}, HUGE_VAL, elastic_flight_s);
    return tracks.empty() ? -INFINITY : tracks.front().log_odds;
  };
  const auto ball = test::candidates_of({.first_flight_s = 1.05, .eps = 0.75, .n_impacts = 3});
  const double alone = log_odds(ball, {});
  EXPECT_GT(log_odds(ball, 1.4), alone + std::log(4.0));  // a fall from 2.4 m, of eps .75
  EXPECT_LT(log_odds(ball, 0.6), alone);                  // the ball would rise higher than it fell
  EXPECT_LT(log_odds(ball, 4.0), log_odds(ball, 1.4));    // eps .26, then .75
  // another sound in the place of the third impact, of eps .45
  const std::vector<Candidate> other{ball[0], ball[1], test::candidate(ball[1].t_s + 0.45 * 1.05, ball[2].amplitude)};
  EXPECT_LT(log_odds(other, 1.4), log_odds(ball, 1.4) - std::log(4.0));
  // a height that is wrong, by its unit for instance, does not lose a ball
  const auto many = test::candidates_of({.n_impacts = 8});
  for (const double wrong_s : {0.05, 0.4, 2.0, 50.0}) EXPECT_GT(log_odds(many, wrong_s), std::log(1e3)) << wrong_s;
}

TEST(Tracker, BeginWithNothingToWhichNoEnergyWasAdded) {
  std::vector<Candidate> candidates;
  double t_s = 0.4;
  double flight_s = 0.6;
  for (int k = 0; k < 9; ++k) {
    candidates.push_back({t_s, k < 2 ? 0.0 : 500.0 * flight_s, 0.4e-3, 50.0});
    t_s += flight_s;
    flight_s *= 0.75;
  }
  const std::vector<Track> tracks = find_tracks(candidates, 5e-5);
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_EQ(tracks[0].impacts.front().candidate, 2u);
  EXPECT_TRUE(std::isfinite(tracks[0].log_odds));
}

}  // namespace
}  // namespace bouncelab::detection
