// SPDX-License-Identifier: GPL-3.0-or-later
// Balls that bounce at the same time, and rows of sounds that only look like a second one; drops that follow soon.
#include <gtest/gtest.h>

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

/// Whether two tracks are the two balls, nine of ten impacts of each and at most one of the other's.
bool are_told_apart(const std::vector<Candidate>& a, const std::vector<Candidate>& b) {
  const std::vector<Candidate> all = test::joined(a, b);
  const std::vector<Track> tracks = find_tracks(all, test::kTiming_s);
  if (tracks.size() != 2) return false;
  const bool a_first = n_of(tracks[0], all, a) > n_of(tracks[0], all, b);
  const Track &of_a = tracks[a_first ? 0 : 1], &of_b = tracks[a_first ? 1 : 0];
  return 10 * n_of(of_a, all, a) >= 9 * a.size() && 10 * n_of(of_b, all, b) >= 9 * b.size() &&
         n_of(of_a, all, b) <= 1 && n_of(of_b, all, a) <= 1;
}

TEST(JointTracks, TwoBallsAtOnceAreTwoTracksOfTheirOwnImpacts) {
  int n_same = 0, n_other = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed, RandomStream::test, 12);
    const double later_s = 0.05 + 0.3 * random.uniform();
    const std::vector<Candidate> first = rough_ball(1.0, 0.45, 0.85, seed);
    n_same += are_told_apart(first, rough_ball(1.0 + later_s, 0.47, 0.85, 100 + seed)) ? 1 : 0;
    n_other += are_told_apart(first, rough_ball(1.0 + later_s, 0.55, 0.78, 200 + seed)) ? 1 : 0;
  }
  // impacts that fall together, and tracks that cross, take some: 31 and 33 of 40 were seen
  EXPECT_GE(n_same, 25);
  EXPECT_GE(n_other, 25);
}

TEST(JointTracks, ThreeBallsAreThree) {
  const std::vector<Candidate> all = test::joined(
      test::joined(rough_ball(1.0, 0.5, 0.8, 1), rough_ball(1.21, 0.62, 0.87, 2)), rough_ball(1.33, 0.4, 0.75, 3));
  EXPECT_EQ(find_tracks(all, test::kTiming_s).size(), 3u);
}

TEST(JointTracks, EchoesAndRattlesOfALoosePlateAreNoSecondBall) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed, RandomStream::test, 13);
    const std::vector<Candidate> ball = rough_ball(1.0, 0.5, 0.82, seed);
    std::vector<Candidate> echoes, rattles;
    for (std::size_t k = 0; k + 1 < ball.size(); ++k) {
      const double flight_s = ball[k + 1].t_s - ball[k].t_s;
      echoes.push_back(test::candidate(ball[k].t_s + 12e-3, 0.6 * ball[k].amplitude));
      rattles.push_back(test::candidate(ball[k].t_s + (0.08 + 0.1 * random.uniform()) * flight_s,
                                        1.2 * ball[k].amplitude * std::exp(0.4 * random.normal())));
    }
    for (const auto& others : {echoes, rattles}) {
      const std::vector<Candidate> all = test::joined(ball, others);
      const std::vector<Track> tracks = find_tracks(all, test::kTiming_s);
      ASSERT_EQ(tracks.size(), 1u) << seed;
      EXPECT_GE(n_of(tracks[0], all, ball), ball.size() - 2) << seed;
    }
  }
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
