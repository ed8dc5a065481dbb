// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/densities.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

double integral_of(const Loudness& loudness) {
  return test::integral_over_line(3.0, 1.0, 2000, [&](double x) { return loudness.density(x, 0.0); });
}

TEST(Loudness, DensityIntegratesToOneHoweverMuchIsKnown) {
  Loudness loudness(3.0);
  EXPECT_NEAR(integral_of(loudness), 1.0, 1e-9);
  Random random(1, RandomStream::test, 0);
  for (int k = 0; k < 30; ++k) {
    loudness.learn(3.0 + 0.2 * random.normal(), 0.0);
    EXPECT_NEAR(integral_of(loudness), 1.0, 1e-9) << k;
  }
}

TEST(Loudness, AnEvenSourceIsKnownBetterThanAnUnevenOne) {
  Loudness even(3.0), uneven(3.0);
  for (int k = 0; k < 20; ++k) {
    even.learn(3.0, 0.0);
    uneven.learn(3.0 + (k % 2 == 0 ? 0.8 : -0.8), 0.0);
  }
  EXPECT_GT(even.density(3.0, 0.0), 1.5 * Loudness(3.0).density(3.0, 0.0));
  EXPECT_LT(uneven.density(3.0, 0.0), Loudness(3.0).density(3.0, 0.0));
  EXPECT_GT(uneven.density(4.5, 0.0), 3.0 * even.density(4.5, 0.0));
}

TEST(Loudness, FollowsGainControl) {
  Loudness loudness(3.0);
  double level = 3.0;
  for (int k = 0; k < 60; ++k) loudness.learn(level += 0.05, 0.0);  // twenty times as loud at the end
  EXPECT_GT(loudness.density(level, 0.0), 10.0 * loudness.density(3.0, 0.0));
}

TEST(Loudness, OneSoundMovesWhatIsKnownByThreeStandardDeviationsAtMost) {
  Loudness by_much(3.0), by_more(3.0);
  by_much.learn(3.0 + 10.0, 0.0);
  by_more.learn(3.0 + 1000.0, 0.0);
  for (const double x : {2.0, 3.0, 4.0}) EXPECT_EQ(by_much.density(x, 0.0), by_more.density(x, 0.0)) << x;
}

TEST(Loudness, OfABallGoesWithAPowerOfItsSpeedThatIsNotKnownWell) {
  // a soft ball, each flight 0.6 of the one before: as loud as in proportion to the speed, its cube, or as before
  const double change = std::log(0.6);
  const Loudness ball(3.0, 0.0);
  const auto density = [&](double exponent) { return ball.density(3.0 + exponent * change, change); };
  EXPECT_GT(density(1.0), 0.7 * density(kTracking.loudness_exponent));
  EXPECT_GT(density(3.0), density(0.0) * 0.4);
  // of a hard ball the exponent hardly matters
  const double little = std::log(0.97);
  for (const double exponent : {0.0, 1.0, 3.0})
    EXPECT_NEAR(ball.density(3.0 + exponent * little, little) / ball.density(3.0, 0.0), 1.0, 0.05);
}

TEST(Loudness, DoesNotDependOnTheGain) {
  Loudness here(3.0), louder(13.0);
  for (const double x : {0.1, -0.3, 2.5}) here.learn(3.0 + x, 0.0), louder.learn(13.0 + x, 0.0);
  EXPECT_NEAR(here.density(3.2, 0.0), louder.density(13.2, 0.0), 1e-12);
}

}  // namespace
}  // namespace bouncelab::detection
