// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rescoring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

const SameSource kNone;

Track track_of(const std::vector<std::size_t>& candidates) {
  Track track;
  for (const std::size_t k : candidates) track.impacts.push_back({k, std::ssize(track.impacts)});
  return track;
}

std::vector<Track> rescored_of(const std::vector<Candidate>& candidates, const std::vector<Track>& tracks) {
  return rescored(Observations(candidates, test::kTiming_s, kNone), tracks);
}

std::vector<std::size_t> candidates_of(const Track& track) {
  std::vector<std::size_t> all;
  for (const TrackImpact& impact : track.impacts) all.push_back(impact.candidate);
  return all;
}

std::vector<std::size_t> from_to(std::size_t first, std::size_t last) {
  std::vector<std::size_t> all;
  for (std::size_t k = first; k <= last; ++k) all.push_back(k);
  return all;
}

TEST(Rescoring, EarlierFirstImpactsAreFound) {
  const std::vector<Candidate> ball = test::candidates_of({});
  const std::vector<Track> tracks = rescored_of(ball, {track_of(from_to(2, 9))});
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_EQ(candidates_of(tracks[0]), from_to(0, 9));
  for (std::size_t k = 0; k < 10; ++k) EXPECT_EQ(tracks[0].impacts[k].impact, static_cast<std::int64_t>(k));
}

TEST(Rescoring, WhatDoesNotFitBeforeTheFirstImpactIsLeft) {
  // where eps would have to be 0.55
  const std::vector<Candidate> candidates = test::joined(test::candidates_of({}), {test::candidate(0.1, 200.0)});
  const std::vector<Track> tracks = rescored_of(candidates, {track_of(from_to(1, 10))});
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_EQ(candidates_of(tracks[0]), from_to(1, 10));
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

TEST(Rescoring, TracksAreGivenInTheOrderOfTime) {
  const std::vector<Candidate> candidates =
      test::joined(test::candidates_of({.n_impacts = 6}), test::candidates_of({.first_s = 20.0}));
  const std::vector<Track> tracks = rescored_of(candidates, {track_of(from_to(0, 5)), track_of(from_to(6, 15))});
  ASSERT_EQ(tracks.size(), 2u);
  EXPECT_GT(tracks[1].log_odds, tracks[0].log_odds);
  EXPECT_EQ(candidates_of(tracks[0]), from_to(0, 5));
}

TEST(Rescoring, UnexplainedSoundsLikeItsOwnMakeATrackLessProbable) {
  const std::vector<Candidate> ball = test::candidates_of({.n_impacts = 6});
  const std::vector<Candidate> between{test::candidate(1.2, 250.0)};
  // of a known other source they would not count: energies tell
  const std::vector<Candidate> both = test::joined(ball, between);
  const auto energies = [&](float slope_of_other) {
    std::vector<BandEnergies> all(both.size());
    for (std::size_t k = 0; k < both.size(); ++k)
      for (std::size_t octave = 0; octave < kEnergyBands; ++octave) {
        all[k].log_power[octave] = (both[k].t_s == 1.2 ? slope_of_other : 3.0F) * static_cast<float>(octave);
        all[k].added_share[octave] = 1.0F;
      }
    return all;
  };
  const Track track = track_of({0, 2, 3, 4, 5, 6});
  const SameSource same(energies(3.0F)), other(energies(-3.0F));
  const auto odds = [&](const SameSource& e) {
    const std::vector<Track> tracks = rescored(Observations(both, test::kTiming_s, e), {track});
    return tracks.empty() ? -INFINITY : tracks[0].log_odds;
  };
  // one, probably of the same source, which competes with the ball's own too
  EXPECT_GT(odds(other) - odds(same), kTracking.unexplained - 0.15);
}

TEST(Rescoring, ARowAtEvenTimesHasLessThanEvenOdds) {
  std::vector<Candidate> row;
  for (int k = 0; k < 12; ++k) row.push_back(test::candidate(1.0 + 0.3 * k, 100.0));
  const std::vector<Track> tracks = rescored_of(row, {track_of(from_to(0, 11))});
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_LT(tracks[0].log_odds, 0.0);
  EXPECT_TRUE(rescored_of(row, {}).empty());
}

}  // namespace
}  // namespace bouncelab::detection
