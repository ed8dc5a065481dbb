// SPDX-License-Identifier: GPL-3.0-or-later
// What the tracker's densities promise in closed form: they integrate to the probability that they stand for.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/observations.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kFlight_s = 0.4;
constexpr double kLogAmplitude = 5.0;

TEST(Student3, IntegratesToOneAndHasTheDistributionOfTheTables) {
  for (const double width : {1e-4, 0.1, 1.0, 30.0})
    // a trigonometric polynomial after the substitution: exact but for rounding
    EXPECT_NEAR(test::integral_over_line(0.0, width, 400, [&](double x) { return student3(x, width); }), 1.0, 1e-12);
  // P(0 < t < x) of three degrees of freedom: 0.475 at 3.182446, 0.495 at 5.840909 (tables, six decimals)
  const auto within = [](double x) { return test::integral(0.0, x, 20000, [](double t) { return student3(t, 1.0); }); };
  EXPECT_NEAR(within(3.182446), 0.475, 1e-7);
  EXPECT_NEAR(within(5.840909), 0.495, 1e-7);
}

/// A ball whose flights all last as long, as far as loudness knows, after some coefficients.
Bounces after(const std::vector<double>& log_eps) {
  Bounces ball(std::log(kFlight_s), kLogAmplitude);
  for (const double each : log_eps) ball.learn(each, std::log(kFlight_s), kLogAmplitude, 0, 0.0);
  return ball;
}

/// And not above the largest, by which the search leaves out what cannot be.
double density_at(const Bounces& ball, double interval_s, double log_amplitude, int n_missing, double jitter2) {
  const std::optional<Flight> flight = flight_of(interval_s, kFlight_s, n_missing);
  if (!flight) return 0.0;
  const double density =
      ball.density(*flight, std::log(flight->eps), std::log(flight->flight_s), log_amplitude, n_missing, jitter2);
  EXPECT_LE(density, (1.0 + 1e-12) * ball.largest_density(*flight, n_missing, jitter2)) << interval_s;
  return density;
}

TEST(Bounces, DensityOverTimeAndLoudnessIntegratesToTheProbabilityOfDetection) {
  const std::vector<std::vector<double>> pasts{{}, {-0.2}, {-0.2, -0.21, -0.19, -0.2}, {-0.2, -0.2, -0.2, -0.5}};
  double sum = 0.0;
  for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing) {
    const double p = probability_of_missing(n_missing);
    sum += p;
    for (const std::vector<double>& past : pasts)
      for (const double jitter2 : {0.0, 1e-4}) {
        const Bounces ball = after(past);
        const double integral = test::integral(0.0, kFlight_s * kMostGap, 10000, [&](double t_s) {
          return test::integral_over_line(kLogAmplitude, 1.0, 40,
                                          [&](double a) { return density_at(ball, t_s, a, n_missing, jitter2); });
        });
        // tails of Student's t outside kLeastEps ... kLargestEps, and steps of the prior there: 3 in 1000; with missing
        // impacts no eps is above 1, where 2 % of the prior are
        const double above_1 = n_missing > 0 ? 0.02 : 0.0;
        EXPECT_LE(integral / p, 1.0 + 3e-3) << past.size() << " coefficients known, " << n_missing << " missing";
        EXPECT_GE(integral / p, 1.0 - above_1 - 3e-3) << past.size() << " known, " << n_missing << " missing";
      }
  }
  EXPECT_NEAR(sum, 1.0 - std::pow(1.0 - kTracking.detection_probability, kMostMissing + 1), 1e-12);
}

/// log of the probability of a loss of n coefficients all the same.
double log_p_loss(double log_eps, int n) {
  Bounces ball(std::log(kFlight_s), kLogAmplitude);
  double log_flight = std::log(kFlight_s);
  for (int k = 0; k < n; ++k) ball.learn(log_eps, log_flight += log_eps, kLogAmplitude, 0, 0.0);
  return ball.log_probability_of_loss(log_flight);
}

TEST(Bounces, ProbabilityOfLossFallsFromThatOfABallWithoutAJumpWhereItsAsymptoticSeriesBegins) {
  EXPECT_NEAR(log_p_loss(-0.2, 10), 0.0, 1e-9);
  double last = 0.0;
  for (double log_eps = -0.03; log_eps < 0.03; log_eps += 1e-5) {  // the series begins at 0.004
    const double here = log_p_loss(log_eps, 9);
    EXPECT_LT(here, last + 0.04) << log_eps;  // the first term of the series is 1/z^2 too large, z = 5
    EXPECT_GT(here, last - 0.1) << log_eps;
    last = here;
  }
  EXPECT_LT(last, -12.0);
  EXPECT_TRUE(std::isfinite(log_p_loss(0.1, 1000)));
}

constexpr double kSigma_s = 7e-5;
using Densities = std::array<double, kRhythmKinds>;

TEST(Rhythm, DensitiesOverTimeAndLoudnessIntegrateToAboutOne) {
  // over a factor of 4.5 either way, in which irregular intervals are even
  const double reach = std::log(4.5);
  Random random(1, RandomStream::test, 0);
  for (const int n_known : {1, 2, 5, 20}) {
    Rhythm rhythm(std::log(kFlight_s), kLogAmplitude);
    for (int k = 1; k < n_known; ++k)
      rhythm.follow(kFlight_s * (1.0 + 0.01 * random.normal()), kLogAmplitude, kSigma_s);
    const auto densities_at = [&](double interval_s, double log_amplitude) {
      return Rhythm(rhythm).follow(interval_s, log_amplitude, kSigma_s);
    };
    const double of_loudness =
        test::integral_over_line(kLogAmplitude, 1.0, 2000, [&](double a) { return densities_at(kFlight_s, a)[0]; }) /
        densities_at(kFlight_s, kLogAmplitude)[0];
    for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
      const double sum = test::integral(-reach, reach, 20000, [&](double log_ratio) {
        const double interval_s = kFlight_s * std::exp(log_ratio);
        return interval_s * densities_at(interval_s, kLogAmplitude)[kind];
      });
      // beats are left out and divided, each by a probability of its own: 1.065 in all, as irregular ones reach it less
      EXPECT_NEAR(sum * of_loudness, 1.0, 0.08) << n_known << " intervals, kind " << kind;
    }
  }
}

TEST(Loudness, IsExpectedByThePowerOfSpeedThatTheTrackShows) {
  for (const double exponent : {0.5, 3.0}) {
    Loudness loudness(0.0, 0.0);
    for (int k = 1; k < 6; ++k) loudness.learn(-0.5 * exponent * k, -0.5 * k);
    const double next = -0.5 * exponent * 6;
    const double off = 0.5 * (exponent - kTracking.loudness_exponent);  // by the power that balls have on the mean
    EXPECT_GT(loudness.density(next, -3.0), 1.1 * loudness.density(next + off, -3.0)) << exponent;
  }
}

Neighbours counted(std::size_t k, const std::vector<Candidate>& candidates,
                   const std::vector<std::size_t>& not_counted = {}) {
  std::vector<double> log_amplitudes;
  for (const Candidate& candidate : candidates) log_amplitudes.push_back(std::log(candidate.amplitude));
  return count_neighbours(k, candidates, log_amplitudes, {}, not_counted);
}

std::vector<Candidate> at_random(int n, double duration_s, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 0);
  std::vector<Candidate> row;
  for (int k = 0; k < n; ++k)
    row.push_back(test::candidate(random.uniform(0.0, duration_s), 100.0 * std::exp(random.normal())));
  test::sort_by_time(row);
  return row;
}

TEST(Clutter, IntensityCountsTheSoundsWithinTheWindowEachOnce) {
  EXPECT_NEAR(test::integral_over_line(0.0, 1.0, 400, [](double x) { return amplitude_kernel(x); }), 1.0, 1e-9);
  const double window_s = clutter_window_s(kFlight_s);
  std::vector<Candidate> row;
  for (int k = 0; k < 41; ++k) row.push_back(test::candidate(1.0 + 0.1 * k, 100.0));
  const double n_others = 2.0 * std::floor(window_s / 0.1);
  const double expected = (n_others + kTracking.unseen) * amplitude_kernel(0.0) / (2.0 * window_s);
  EXPECT_NEAR(clutter_intensity(counted(20, row), kFlight_s, 0.0) / expected, 1.0, 1e-5);  // as floats
}

TEST(Clutter, IntensityOverAllLoudnessesIsTheRateOfThePoissonProcess) {
  // a probe of any loudness, uniform over +-8: its mean intensity times 16 is the rate of the others
  constexpr double kRange = 16.0;
  double sum = 0.0;
  constexpr int kSeeds = 400;
  constexpr double kDuration_s = 10.0, kRate_hz = 12.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed, RandomStream::test, 1);
    const Candidate probe = test::candidate(0.5 * kDuration_s, 100.0 * std::exp(kRange * (random.uniform() - 0.5)));
    const std::vector<Candidate> row =
        test::joined(at_random(static_cast<int>(kDuration_s * kRate_hz), kDuration_s, seed), {probe});
    const auto here = std::find_if(row.begin(), row.end(), [&](const Candidate& c) { return c.t_s == probe.t_s; });
    const auto k = static_cast<std::size_t>(here - row.begin());
    sum += kRange * (clutter_intensity(counted(k, row), kFlight_s, 0.0) - least_clutter_intensity(kFlight_s));
  }
  // each probe counts what is within a range of about 2 of 16: 400 of them give the mean to a tenth
  EXPECT_NEAR(sum / kSeeds, kRate_hz, 0.25 * kRate_hz);
}

TEST(Clutter, WhatIsNotCountedMightAsWellNotBeThere) {
  const std::vector<Candidate> row = at_random(60, 6.0, 1);
  const std::vector<std::size_t> left_out{3, 20, 29, 31, 40};
  std::vector<Candidate> others;
  for (std::size_t k = 0; k < row.size(); ++k)
    if (!std::binary_search(left_out.begin(), left_out.end(), k)) others.push_back(row[k]);
  std::size_t at = 0;
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (std::binary_search(left_out.begin(), left_out.end(), k)) continue;
    const Neighbours some = counted(k, row, left_out), fewer = counted(at++, others);
    EXPECT_EQ(some.all, fewer.all);
    EXPECT_EQ(some.stronger, fewer.stronger);
    EXPECT_EQ(some.density, fewer.density);
  }
}

TEST(Clutter, SharesOfTheFirstImpactSumToOne) {
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

TEST(RiseOdds, ProbabilitiesSumToTheNumberOfEvents) {
  constexpr double kInWindow = 18.0;  // samples of 0.4 ms at 44.1 kHz
  const double z0 = kTracking.event_per_sample * kInWindow;
  const double excess = kTracking.excess + kTracking.excess_per_sample * kInWindow;
  for (const double share : {0.2, 0.5, 0.8}) {
    Random random(1, RandomStream::test, 0);
    std::vector<Candidate> candidates;  // 20 ms apart as the model has them
    double expected = 0.0, n_events = 0.0;
    for (int k = 0; k < 8000; ++k) {
      const bool is_event = random.uniform() < share;
      const double u = random.uniform(), z = is_event ? z0 * u / (1.0 - u) : excess * random.exponential();
      candidates.push_back(test::candidate(0.02 * k, 100.0, kCandidates.threshold + z));
      n_events += is_event ? 1.0 : 0.0;
    }
    for (const double odds : log_rise_odds(candidates, kInWindow)) expected += share * std::exp(odds);
    // the share is estimated from 48 neighbours and a prior of one half
    EXPECT_NEAR(expected / n_events, 1.0, 0.15) << share;
  }
  // p(LLR | event) / p(LLR) with one half: between nothing and log 2
  EXPECT_NEAR(log_rise_odds({test::candidate(1.0, 100.0, 1e4)}, kInWindow)[0], std::log(2.0), 1e-6);
  EXPECT_LT(log_rise_odds({test::candidate(1.0, 100.0, kCandidates.threshold)}, kInWindow)[0], 0.0);
}

}  // namespace
}  // namespace bouncelab::detection
