// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/bounces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kFlight_s = 0.4;
constexpr double kLogAmplitude = 5.0;

/// A ball whose flights all last as long, as far as loudness knows, after some coefficients.
Bounces after(const std::vector<double>& log_eps) {
  Bounces ball(std::log(kFlight_s), kLogAmplitude);
  for (const double each : log_eps) ball.learn(each, std::log(kFlight_s), kLogAmplitude, 0, 0.0);
  return ball;
}

double density_at(const Bounces& ball, double interval_s, double log_amplitude, int n_missing, double jitter2 = 0.0) {
  const std::optional<Flight> flight = flight_of(interval_s, kFlight_s, n_missing);
  return flight ? ball.density(*flight, std::log(flight->eps), std::log(flight->flight_s), log_amplitude, n_missing,
                               jitter2)
                : 0.0;
}

double density_of_eps(const Bounces& ball, double log_eps) {
  return density_at(ball, kFlight_s * std::exp(log_eps), kLogAmplitude + log_eps, 0);
}

/// Over all times and log amplitudes of the next detected impact.
double integral_of(const Bounces& ball, int n_missing, double jitter2) {
  const double most_s = kFlight_s * kMostGap;
  return test::integral(0.0, most_s, 20000, [&](double t_s) {
    return test::integral_over_line(kLogAmplitude, 1.0, 40,
                                    [&](double a) { return density_at(ball, t_s, a, n_missing, jitter2); });
  });
}

TEST(Bounces, DensityOverTimeAndLoudnessIntegratesToTheProbabilityOfDetection) {
  const std::vector<std::vector<double>> pasts{{}, {-0.2}, {-0.2, -0.21, -0.19, -0.2}, {-0.2, -0.2, -0.2, -0.5}};
  for (const std::vector<double>& past : pasts)
    for (const double jitter2 : {0.0, 1e-4})
      for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing) {
        const double p = probability_of_missing(n_missing);
        // tails of Student's t outside kLeastEps ... kLargestEps, and steps of the prior there: 3 in 1000
        EXPECT_NEAR(integral_of(after(past), n_missing, jitter2) / p, 1.0, 3e-3)
            << past.size() << " coefficients known, " << n_missing << " missing";
      }
}

TEST(Bounces, NoDensityIsAboveTheLargest) {
  const std::vector<std::vector<double>> pasts{
      {}, {-0.2}, {-0.2, -0.21, -0.19, -0.2}, {-0.2, -0.2, -0.2, -0.5}, std::vector<double>(12, -0.05)};
  for (const std::vector<double>& past : pasts)
    for (const double jitter2 : {0.0, 1e-4})
      for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing) {
        const Bounces ball = after(past);
        for (double interval_s = 0.3 * kFlight_s; interval_s < 5.0 * kFlight_s; interval_s *= 1.01) {
          const std::optional<Flight> flight = flight_of(interval_s, kFlight_s, n_missing);
          if (!flight) continue;
          const double largest = ball.largest_density(*flight, n_missing, jitter2);
          for (const double log_amplitude : {kLogAmplitude - 1.0, kLogAmplitude, kLogAmplitude + 0.3})
            EXPECT_LE(density_at(ball, interval_s, log_amplitude, n_missing, jitter2), (1.0 + 1e-12) * largest)
                << interval_s;
        }
      }
}

TEST(Bounces, PriorOfEpsIntegratesToOneWithinItsLimits) {
  const auto prior = [](double eps) { return prior_of_eps(eps); };
  EXPECT_NEAR(test::integral(0.0, 2.0, 20000, prior), 1.0, 1e-9);
  EXPECT_EQ(prior(kLeastEps - 1e-9), 0.0);
  EXPECT_EQ(prior(kLargestEps + 1e-9), 0.0);
  EXPECT_GT(prior(0.99), 5.0 * prior(1.01));
}

TEST(Bounces, FlightsAfterTheImpactsThatAreMissingAreThoseOfOneEps) {
  for (const double eps : {0.42, 0.7, 0.95, 1.15}) {
    double interval_s = 0.0, flight_s = kFlight_s;
    for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing) {
      interval_s += flight_s *= eps;
      const std::optional<Flight> flight = flight_of(interval_s, kFlight_s, n_missing);
      ASSERT_TRUE(flight) << eps;
      EXPECT_NEAR(flight->eps, eps, 1e-10);  // four of Newton's steps
      EXPECT_NEAR(flight->flight_s, flight_s, 1e-10);
      const double later_s = 1e-6;
      const double slope_s = later_s / (flight_of(interval_s + later_s, kFlight_s, n_missing)->eps - flight->eps);
      EXPECT_NEAR(flight->slope_s / slope_s, 1.0, 1e-4);  // a difference quotient
    }
  }
}

TEST(Bounces, NoFlightIsOutsideTheLimits) {
  EXPECT_FALSE(flight_of(0.999 * kLeastEps, 1.0, 0));
  EXPECT_TRUE(flight_of(1.001 * kLeastEps, 1.0, 0));
  EXPECT_TRUE(flight_of(0.999 * kLargestEps, 1.0, 0));
  EXPECT_FALSE(flight_of(1.001 * kLargestEps, 1.0, 0));
  EXPECT_TRUE(flight_of(0.999 * kMostGap, 1.0, kMostMissing));
  EXPECT_FALSE(flight_of(1.001 * kMostGap, 1.0, kMostMissing));
  EXPECT_FALSE(flight_of(0.9 * kShortestFlight_s, kShortestFlight_s, 0));
}

TEST(Bounces, ASingleLossIsNotFollowed) {
  const double before = density_of_eps(after({-0.2, -0.2, -0.2, -0.2, -0.2}), -0.2);
  const Bounces ball = after({-0.2, -0.2, -0.2, -0.2, -0.2, -0.6});
  EXPECT_GT(density_of_eps(ball, -0.2), 5.0 * density_of_eps(ball, -0.4));  // between the two there is nothing
  EXPECT_GT(density_of_eps(ball, -0.2), 0.4 * before);
  const Bounces back = after({-0.2, -0.2, -0.2, -0.2, -0.2, -0.6, -0.2});
  EXPECT_GT(density_of_eps(back, -0.2), 20.0 * density_of_eps(back, -0.6));
}

TEST(Bounces, AChangeThatStaysIsFollowed) {
  const std::vector<double> past{-0.2, -0.2, -0.2, -0.2, -0.2, -0.6};
  // the first time nothing tells it from a single loss, but it may stay
  EXPECT_GT(density_of_eps(after(past), -0.6), 3.0 * density_of_eps(after({-0.2, -0.2, -0.2, -0.2, -0.2}), -0.6));
  std::vector<double> stayed = past;
  stayed.push_back(-0.6);
  EXPECT_GT(density_of_eps(after(stayed), -0.6), 10.0 * density_of_eps(after(stayed), -0.2));
}

TEST(Bounces, ASmoothBallIsKnownBetterThanARoughOne) {
  std::vector<double> smooth, rough;
  for (int k = 0; k < 12; ++k) smooth.push_back(-0.2), rough.push_back(k % 2 == 0 ? -0.16 : -0.24);
  EXPECT_GT(density_of_eps(after(smooth), -0.2), 3.0 * density_of_eps(after(rough), -0.2));
  EXPECT_GT(density_of_eps(after(rough), -0.26), 10.0 * density_of_eps(after(smooth), -0.26));
}

/// log of the probability of a loss of n coefficients all the same.
double log_p_loss(double log_eps, int n) {
  Bounces ball(std::log(kFlight_s), kLogAmplitude);
  double log_flight = std::log(kFlight_s);
  for (int k = 0; k < n; ++k) ball.learn(log_eps, log_flight += log_eps, kLogAmplitude, 0, 0.0);
  return ball.log_probability_of_loss(log_flight);
}

TEST(Bounces, ProbabilityOfLossIsOneForABallAndVanishesForWhatGains) {
  EXPECT_EQ(Bounces(0.0, 0.0).log_probability_of_loss(0.0), 0.0);  // nothing is known
  EXPECT_NEAR(log_p_loss(-0.2, 10), 0.0, 1e-9);
  EXPECT_NEAR(log_p_loss(-kTracking.least_loss, 10), std::log(0.5), 1e-9);
  EXPECT_LT(log_p_loss(0.0, 100), -10.0);  // a metronome
  EXPECT_LT(log_p_loss(0.1, 10), -100.0);
  EXPECT_TRUE(std::isfinite(log_p_loss(0.1, 1000)));
}

TEST(Bounces, ProbabilityOfLossFallsWithoutAJumpWhereItsAsymptoticSeriesBegins) {
  double last = 0.0;
  for (double log_eps = -0.03; log_eps < 0.03; log_eps += 1e-5) {  // the series begins at 0.004
    const double here = log_p_loss(log_eps, 9);
    EXPECT_LT(here, last + 0.04) << log_eps;  // the first term of the series is 1/z^2 too large, z = 5
    EXPECT_GT(here, last - 0.1) << log_eps;
    last = here;
  }
  EXPECT_LT(last, -12.0);
}

TEST(Bounces, SingleLossesMakeNoBallOfARhythm) {
  std::vector<double> even(30, 0.0), with_gaps(30, 0.0);
  with_gaps[10] = with_gaps[20] = -0.6;
  const double log_flight = std::log(kFlight_s);
  EXPECT_LT(after(even).log_probability_of_loss(log_flight), std::log(0.1));
  EXPECT_LT(after(with_gaps).log_probability_of_loss(log_flight), std::log(0.6));
}

TEST(Bounces, WhatIsLostBeforeAndAfterAnEvenStretchDoesNotMakeItABalls) {
  std::vector<double> log_eps(60, 0.0);
  for (int k = 0; k < 10; ++k) log_eps[static_cast<std::size_t>(k)] = log_eps[static_cast<std::size_t>(59 - k)] = -0.2;
  double log_flight = std::log(kFlight_s);
  for (const double each : log_eps) log_flight += each;
  EXPECT_LT(after(log_eps).log_probability_of_loss(log_flight), -5.0);  // 0.067 on the whole
}

TEST(Bounces, ProbabilitiesOfMissingSumToOneButForMoreThanTheMost) {
  double sum = 0.0;
  for (int n = 0; n <= kMostMissing; ++n) sum += probability_of_missing(n);
  EXPECT_NEAR(sum, 1.0 - std::pow(1.0 - kTracking.detection_probability, kMostMissing + 1), 1e-12);
}

}  // namespace
}  // namespace bouncelab::detection
