// SPDX-License-Identifier: GPL-3.0-or-later
// Balls that bounce at the same time, and rows of sounds that only look like a second one; drops that follow soon.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::uint64_t kSeeds = 40;

/// Impacts of a track that are candidates of a row.
std::size_t n_of(const Track& track, const std::vector<Candidate>& all, const std::vector<Candidate>& row) {
  std::size_t n = 0;
  for (const TrackImpact& impact : track.impacts)
    for (const Candidate& c : row) n += all[impact.candidate].t_s == c.t_s ? 1 : 0;
  return n;
}

std::vector<Candidate> rough_ball(double first_s, double first_flight_s, double eps, std::uint64_t seed) {
  return test::candidates_of({.first_s = first_s,
                              .first_flight_s = first_flight_s,
                              .eps = eps,
                              .n_impacts = 14,
                              .eps_scatter = 0.01,
                              .loudness_scatter = 0.2},
                             Random(seed, RandomStream::test, 11));
}

/// Impacts of two balls, and those that are in the right one of two tracks or in the wrong one.
struct Shares {
  double all = 0.0, right = 0.0, wrong = 0.0;
  void add(const std::vector<Candidate>& a, const std::vector<Candidate>& b) {
    const std::vector<Candidate> together = test::joined(a, b);
    all += static_cast<double>(together.size());
    for (const Track& track : find_tracks(together, test::kTiming_s)) {
      const std::size_t of_a = n_of(track, together, a), of_b = n_of(track, together, b);
      right += static_cast<double>(std::max(of_a, of_b));
      wrong += static_cast<double>(std::min(of_a, of_b));
    }
  }
};

TEST(JointTracks, TwoBallsAtOnceAreTracksOfTheirOwnImpacts) {
  Shares same, other;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed, RandomStream::test, 12);
    const double later_s = 0.05 + 0.3 * random.uniform();
    const std::vector<Candidate> first = rough_ball(1.0, 0.45, 0.85, seed);
    same.add(first, rough_ball(1.0 + later_s, 0.47, 0.85, 100 + seed));
    other.add(first, rough_ball(1.0 + later_s, 0.55, 0.78, 200 + seed));
  }
  // as of the sounds of two balls; a track that crosses another may take over its end
  for (const Shares& shares : {same, other}) {
    EXPECT_GT(shares.right, 0.87 * shares.all);
    EXPECT_LT(shares.wrong, 0.05 * shares.all);
  }
}

TEST(JointTracks, BallsWhoseImpactsCrossKeepTheirOwn) {
  // their flights are nearly the same, so that for several impacts in a row each is where the other's echo may be
  Shares shares;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed, RandomStream::test, 15);
    const auto ball = [&](double first_s, double first_flight_s, double eps, std::uint64_t of) {
      return test::candidates_of({.first_s = first_s,
                                  .first_flight_s = first_flight_s,
                                  .eps = eps,
                                  .n_impacts = 20,
                                  .eps_scatter = 0.001,
                                  .loudness_scatter = 0.1},
                                 Random(seed, RandomStream::test, of));
    };
    const double later_s = 0.02 + 0.04 * random.uniform();
    shares.add(ball(1.0, 0.27, 0.97, 16), ball(1.0 + later_s, 0.262, 0.97, 17));
  }
  EXPECT_GT(shares.right, 0.97 * shares.all);
  EXPECT_LT(shares.wrong, 0.01 * shares.all);
}

TEST(JointTracks, ThreeBallsAreThree) {
  const std::vector<Candidate> all = test::joined(
      test::joined(rough_ball(1.0, 0.5, 0.8, 1), rough_ball(1.21, 0.62, 0.87, 2)), rough_ball(1.33, 0.4, 0.75, 3));
  EXPECT_EQ(find_tracks(all, test::kTiming_s).size(), 3u);
}

TEST(JointTracks, EchoesReflectionsAndRattlesAreNoSecondBall) {
  std::size_t n_second = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed, RandomStream::test, 13);
    const std::vector<Candidate> ball = rough_ball(1.0, 0.5, 0.82, seed);
    std::vector<Candidate> echoes, rattles, reflections;  // one of several, another time another
    for (std::size_t k = 0; k + 1 < ball.size(); ++k) {
      const double flight_s = ball[k + 1].t_s - ball[k].t_s;
      echoes.push_back(test::candidate(ball[k].t_s + 12e-3, 0.6 * ball[k].amplitude));
      rattles.push_back(test::candidate(ball[k].t_s + (0.03 + 0.3 * random.uniform()) * flight_s,
                                        1.2 * ball[k].amplitude * std::exp(0.4 * random.normal())));
      for (const double after_s : {6e-3, 9e-3, 13e-3, 18e-3, 24e-3, 33e-3})
        if (random.uniform() < 0.7)
          reflections.push_back(test::candidate(ball[k].t_s + after_s + 0.5e-3 * random.normal(),
                                                0.4 * ball[k].amplitude * std::exp(0.4 * random.normal())));
    }
    for (const auto& others : {echoes, rattles, reflections}) {
      const std::vector<Candidate> all = test::joined(ball, others);
      const std::vector<Track> tracks = find_tracks(all, test::kTiming_s);
      n_second += tracks.size() - 1;
    }
  }
  EXPECT_LE(n_second, kSeeds / 20);  // rattles that chance has put where a ball would be
}

TEST(JointTracks, DropsThatFollowSoonAreNotJoinedByMissingImpacts) {
  for (const double pause_s : {0.4, 0.6, 0.8}) {
    std::vector<Candidate> all;
    double first_s = 1.0;
    for (int drop = 0; drop < 10; ++drop) {
      const std::vector<Candidate> ball = test::candidates_of(
          {.first_s = first_s, .first_flight_s = 0.25, .eps = 0.975, .n_impacts = 12, .eps_scatter = 0.002},
          Random(static_cast<std::uint64_t>(drop), RandomStream::test, 14));
      all = test::joined(all, ball);
      first_s = ball.back().t_s + pause_s;
    }
    EXPECT_EQ(find_tracks(all, test::kTiming_s).size(), 10u) << pause_s;
  }
}

}  // namespace
}  // namespace bouncelab::detection
