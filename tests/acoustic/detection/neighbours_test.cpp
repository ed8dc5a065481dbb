// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kFlight_s = 0.4;

std::vector<double> log_amplitudes(const std::vector<Candidate>& candidates) {
  std::vector<double> logs;
  for (const Candidate& candidate : candidates) logs.push_back(std::log(candidate.amplitude));
  return logs;
}

Neighbours counted(std::size_t k, const std::vector<Candidate>& candidates, const SameSource& same_source = {},
                   const std::vector<std::size_t>& not_counted = {}) {
  return count_neighbours(k, candidates, log_amplitudes(candidates), same_source, not_counted);
}

/// As loud sounds at even times.
std::vector<Candidate> even_row(int n, double interval_s) {
  std::vector<Candidate> row;
  for (int k = 0; k < n; ++k) row.push_back(test::candidate(1.0 + k * interval_s, 100.0));
  return row;
}

std::vector<Candidate> at_random(int n, double duration_s, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 0);
  std::vector<Candidate> row;
  for (int k = 0; k < n; ++k)
    row.push_back(test::candidate(random.uniform(0.0, duration_s), 100.0 * std::exp(random.normal())));
  test::sort_by_time(row);
  return row;
}

TEST(Neighbours, WindowIsBetweenTheRootOfTwoAndOfEightFlights) {
  for (double flight_s = kShortestFlight_s; flight_s < 1.4; flight_s *= 1.01) {
    EXPECT_GT(clutter_window_s(flight_s), 0.999 * std::sqrt(2.0) * flight_s) << flight_s;
    EXPECT_LT(clutter_window_s(flight_s), 1.001 * std::sqrt(8.0) * flight_s) << flight_s;
  }
}

TEST(Neighbours, KernelIntegratesToOneSoThatOneSoundCountsOnce) {
  EXPECT_NEAR(test::integral_over_line(0.0, 1.0, 400, [](double x) { return amplitude_kernel(x); }), 1.0, 1e-9);
}

TEST(Neighbours, IntensityCountsTheSoundsWithinTheWindow) {
  const double window_s = clutter_window_s(kFlight_s);
  const std::vector<Candidate> row = even_row(41, 0.1);
  const double n_others = 2.0 * std::floor(window_s / 0.1);
  const double expected = (n_others + kTracking.unseen) * amplitude_kernel(0.0) / (2.0 * window_s);
  EXPECT_NEAR(clutter_intensity(counted(20, row), kFlight_s, 0.0) / expected, 1.0, 1e-5);  // as floats
}

TEST(Neighbours, IntensityOverAllLoudnessesIsTheRateOfThePoissonProcess) {
  // a probe of any loudness, uniform over +-8: its mean intensity times 16 is the rate of the others
  constexpr double kRange = 16.0;
  double sum = 0.0;
  constexpr int kSeeds = 400;
  constexpr double kDuration_s = 10.0, kRate_hz = 12.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::vector<Candidate> row = at_random(static_cast<int>(kDuration_s * kRate_hz), kDuration_s, seed);
    Random random(seed, RandomStream::test, 1);
    Candidate probe = test::candidate(0.5 * kDuration_s, 100.0 * std::exp(kRange * (random.uniform() - 0.5)));
    row = test::joined(row, {probe});
    const auto here = std::find_if(row.begin(), row.end(), [&](const Candidate& c) { return c.t_s == probe.t_s; });
    const auto k = static_cast<std::size_t>(here - row.begin());
    sum += kRange * (clutter_intensity(counted(k, row), kFlight_s, 0.0) - least_clutter_intensity(kFlight_s));
  }
  // each probe counts what is within a range of about 2 of 16: 400 of them give the mean to a tenth
  EXPECT_NEAR(sum / kSeeds, kRate_hz, 0.25 * kRate_hz);
}

TEST(Neighbours, WhereNoneIsNearThoseAroundSayHowManyToExpect) {
  Neighbours n;
  const double itself = amplitude_kernel(0.0), window_s = 2.0 * clutter_window_s(kFlight_s);
  n.density.fill(static_cast<float>(itself));
  n.around_s = 8.0F;
  // none at all: as many as in the window and around it together
  EXPECT_NEAR(clutter_intensity(n, kFlight_s) / (kTracking.unseen * itself / (window_s + 8.0)), 1.0, 1e-6);
  // a recording that is no longer says no more than itself
  n.around_s = 0.5F;
  EXPECT_NEAR(clutter_intensity(n, kFlight_s) / (kTracking.unseen * itself / (0.5 + 0.5)), 1.0, 1e-6);
  // very many, evenly: the intensity is theirs
  const double rate_hz = 1e3;
  for (int octave = 0; octave < kWindowOctaves; ++octave)
    n.density[octave] = static_cast<float>(itself * (1.0 + rate_hz * 2.0 * kSmallestReach_s * (1 << octave)));
  n.around_s = static_cast<float>(2.0 * kLargestReach_s);
  EXPECT_NEAR(clutter_intensity(n, kFlight_s) / (rate_hz * itself), 1.0, 1e-3);
}

TEST(Neighbours, OwnSoundsAreNoClutter) {
  const std::vector<Candidate> row = even_row(9, 0.2);
  const Neighbours n = counted(4, row);
  const double one = amplitude_kernel(0.0) / (2.0 * clutter_window_s(kFlight_s));
  const double all = clutter_intensity(n, kFlight_s, 0.0);
  const double without_two = clutter_intensity(n, kFlight_s, 2.0 * amplitude_kernel(0.0));
  EXPECT_NEAR(all - without_two, 2.0 * one, 1e-5 * all);
  // and where all are, what is left is the prior
  EXPECT_NEAR(clutter_intensity(n, kFlight_s, 1e3), kTracking.unseen * one, 1e-12);
}

TEST(Neighbours, WhatIsNotCountedMightAsWellNotBeThere) {
  const std::vector<Candidate> row = at_random(60, 6.0, 1);
  const std::vector<std::size_t> left_out{3, 20, 29, 31, 40};
  std::vector<Candidate> others;
  for (std::size_t k = 0; k < row.size(); ++k)
    if (!std::binary_search(left_out.begin(), left_out.end(), k)) others.push_back(row[k]);
  std::size_t at = 0;
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (std::binary_search(left_out.begin(), left_out.end(), k)) continue;
    const Neighbours some = counted(k, row, {}, left_out), fewer = counted(at, others);
    EXPECT_EQ(some.all, fewer.all);
    EXPECT_EQ(some.stronger, fewer.stronger);
    EXPECT_EQ(some.density, fewer.density);
    ++at;
  }
}

TEST(Neighbours, ASoundOfAnotherSourceHardlyCounts) {
  const std::vector<Candidate> row = even_row(3, 0.1);
  const SameSource same({test::tilted(3), test::tilted(3), test::tilted(3)}),
      other({test::tilted(-3), test::tilted(3), test::tilted(-3)});
  EXPECT_NEAR(counted(1, row, same).all, 3.0, 1e-6);
  EXPECT_LT(counted(1, row, other).all, 1.2);
}

TEST(Neighbours, SharesOfTheFirstImpactSumToOne) {
  for (const int n : {2, 10, 100}) {
    double sum = 0.0;
    for (int rank = 1; rank <= n; ++rank) {
      Neighbours neighbours;
      neighbours.all = static_cast<float>(n);
      neighbours.stronger = static_cast<float>(rank);
      sum += std::exp(-log_odds_against_first(neighbours));
    }
    EXPECT_NEAR(sum, 1.0, 0.02) << n;  // the series for the harmonic number
  }
}

TEST(Neighbours, OfManyTheLoudestIsTheLikeliestFirstImpact) {
  const std::vector<Candidate> row = at_random(30, 3.0, 2);
  const auto loudest = static_cast<std::size_t>(
      std::max_element(row.begin(), row.end(),
                       [](const Candidate& a, const Candidate& b) { return a.amplitude < b.amplitude; }) -
      row.begin());
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (k == loudest) continue;
    EXPECT_GT(log_odds_against_first(counted(k, row)), log_odds_against_first(counted(loudest, row))) << k;
  }
}

}  // namespace
}  // namespace bouncelab::detection
