// SPDX-License-Identifier: GPL-3.0-or-later
// Contact time from the band levels of a drop: levels made of a known response and known pulses.
#include "contact/contact_time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"

namespace bouncelab::detection {
namespace {

struct Ball {
  double tau_1_s = 30e-6;
  double scatter = 0.1;  // of each level, at each impact
  double drift = 0.0;    // of each level over the drop, as of a ball that wanders
  double noise = 0.02;   // over the level of the strongest impact
  double largest_hz = 20e3;
};

const ContactLaw kSteel = assumed_contact(9e3);

/// Eighty bounces from 1.3 to 0.2 m/s, 30 bands.
BandLevels levels_of(const Ball& ball, std::uint64_t seed) {
  constexpr int kImpacts = 80;
  constexpr int kBands = 30;
  Random random(seed, RandomStream::test, 11);
  BandLevels levels;
  std::vector<double> response, drift;
  for (int m = 0; m < kBands; ++m) {
    levels.f_hz.push_back(ball.largest_hz * (m + 1.0) / kBands);
    levels.noise2.push_back(ball.noise * ball.noise);
    response.push_back(std::exp(0.5 * random.normal()));
    drift.push_back(ball.drift * random.normal());
  }
  for (int k = 0; k < kImpacts; ++k) {
    const double v_mps = 1.3 * std::pow(0.2 / 1.3, k / (kImpacts - 1.0));
    levels.contact_scaling.push_back(std::pow(v_mps, -0.2));
    std::vector<double> row;
    for (std::size_t m = 0; m < levels.f_hz.size(); ++m) {
      const double pulse = pulse_spectrum(levels.f_hz[m] * ball.tau_1_s * levels.contact_scaling.back()).value;
      const double factor = 1.0 + ball.scatter * random.normal() + drift[m] * (k / (kImpacts - 1.0) - 0.5);
      row.push_back(v_mps * response[m] * pulse * factor + ball.noise * random.normal());
    }
    levels.level.push_back(row);
  }
  return levels;
}

struct Outcome {
  double bias = 0.0;  // mean error over the standard error of the mean
  double pull = 0.0;  // rms of error over standard error, of tau^2
};

Outcome over_seeds(const Ball& ball) {
  constexpr int kTrials = 60;
  Outcome outcome;
  const double truth = ball.tau_1_s * ball.tau_1_s;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    const std::optional<ContactFit> fit = fit_contact(levels_of(ball, seed));
    EXPECT_TRUE(fit) << seed;
    if (!fit) return outcome;
    outcome.bias += (fit->tau2_s2 - truth) / fit->sigma2_s2 / std::sqrt(kTrials);
    outcome.pull += std::pow((fit->tau2_s2 - truth) / fit->sigma2_s2, 2) / kTrials;
  }
  outcome.pull = std::sqrt(outcome.pull);
  return outcome;
}

TEST(ContactTime, GivesBackTheDurationWithinItsStatedError) {
  // the rms of 60 pulls scatters by 9 %, and the error is itself estimated from 30 bands, to 13 %
  for (const double tau_1_s : {20e-6, 30e-6, 40e-6}) {
    Ball ball;
    ball.tau_1_s = tau_1_s;
    const Outcome outcome = over_seeds(ball);
    EXPECT_NEAR(outcome.bias, 0.0, 3.0) << tau_1_s;
    EXPECT_GT(outcome.pull, 0.7) << tau_1_s;
    EXPECT_LT(outcome.pull, 1.35) << tau_1_s;
  }
}

TEST(ContactTime, CountsAModeThatDriftsOnceAndNotAsOftenAsItWasStruck) {
  Ball ball;
  ball.drift = 0.3;
  const Outcome outcome = over_seeds(ball);
  EXPECT_GT(outcome.pull, 0.7);
  EXPECT_LT(outcome.pull, 1.35);
}

TEST(ContactTime, IsUncertainWhereTheSoundEndsFarBelowTheContact) {
  // below 3 kHz a contact of 30 us lowers the levels by 1 %
  Ball ball;
  ball.largest_hz = 3e3;
  const std::optional<ContactFit> fit = fit_contact(levels_of(ball, 1));
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->sigma2_s2, 30e-6 * 30e-6);
  const ContactLaw law = pool_contacts({*fit}, kSteel);
  EXPECT_FALSE(law.is_significant);
  EXPECT_NEAR(law.tau_1_s, kSteel.tau_1_s, kSteel.sigma_s);
}

TEST(ContactTime, ManyDropsThatAreEachUncertainDetermineItTogether) {
  Ball ball;
  ball.largest_hz = 8e3;
  std::vector<ContactFit> drops;
  for (std::uint64_t seed = 0; seed < 50; ++seed) drops.push_back(*fit_contact(levels_of(ball, seed)));
  const ContactLaw one = pool_contacts({drops[0]}, kSteel);
  const ContactLaw all = pool_contacts(drops, kSteel);
  EXPECT_TRUE(all.is_significant);
  EXPECT_LT(all.sigma_s, 0.4 * one.sigma_s);
  EXPECT_NEAR(all.tau_1_s, 30e-6, 3.0 * all.sigma_s);
}

TEST(ContactTime, AssumedIsOfTheOrderOfHalfAPeriodOfTheSound) {
  EXPECT_NEAR(kSteel.tau_1_s, 29e-6, kSteel.sigma_s);  // 3 mm of radius on glass, Hertz
  const ContactLaw rubber = assumed_contact(130.0);
  EXPECT_NEAR(rubber.tau_1_s, 4e-3, rubber.sigma_s);
  EXPECT_NEAR(rubber.tau_1_s / kSteel.tau_1_s, 9e3 / 130.0, 1e-9);
}

TEST(ContactTime, OfALongPulseIsNotDrawnToThatOfSteel) {
  Ball ball;
  ball.tau_1_s = 250e-6;
  ball.largest_hz = 3e3;
  const std::optional<ContactFit> fit = fit_contact(levels_of(ball, 1));
  ASSERT_TRUE(fit);
  const ContactLaw law = pool_contacts({*fit}, assumed_contact(1.5e3));
  EXPECT_NEAR(law.tau_1_s, ball.tau_1_s, 3.0 * law.sigma_s);
  EXPECT_LT(law.sigma_s, 60e-6);
}

TEST(ContactTime, OfBandsThatHoldNoiseAloneIsOfABallOrAbsent) {
  Ball ball;
  ball.tau_1_s = 480e-6;  // a golf ball: above 4 kHz its pulse leaves a thousandth
  ball.largest_hz = 6e3;
  std::size_t n_absent = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    ball.noise = 0.002 * static_cast<double>(1 + seed % 10);
    const std::optional<ContactFit> fit = fit_contact(levels_of(ball, seed));
    if (fit)
      EXPECT_LT(fit->sigma2_s2, 50e-3 * 50e-3) << seed;
    else
      ++n_absent;
  }
  EXPECT_LT(n_absent, 60u);
}

TEST(ContactTime, IsAbsentWithoutImpactsOrBands) {
  BandLevels few = levels_of({}, 1);
  few.contact_scaling.resize(7);
  few.level.resize(7);
  EXPECT_FALSE(fit_contact(few));
  EXPECT_FALSE(fit_contact({}));
  EXPECT_EQ(pool_contacts({}, kSteel).tau_1_s, kSteel.tau_1_s);
}

}  // namespace
}  // namespace bouncelab::detection
