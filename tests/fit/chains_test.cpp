// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/chains.hpp"

#include <gtest/gtest.h>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::fit {
namespace {

/// Onsets of one drop without scatter, the error of each its own.
Onsets onsets_of(std::size_t n, std::int64_t drop = 0) {
  Onsets onsets;
  double t = 0.0, v = 1.4;
  for (std::size_t k = 0; k < n; ++k) {
    Onset onset;
    onset.drop = drop;
    onset.impact = static_cast<std::int64_t>(k);
    onset.t_s = t;
    onset.sigma_t_s = 1e-7 * (1.0 + static_cast<double>(k % 3));
    onsets.push_back(onset);
    v *= 0.98;
    t += 2.0 * v / 9.81;
  }
  return onsets;
}

RestitutionSamples samples_of(const Onsets& onsets) { return restitution_samples(onsets, {}).samples; }

TEST(Chains, TimesHaveTheErrorsOfTheOnsets) {
  const Onsets onsets = onsets_of(12);
  const Chains chains = chains_of(samples_of(onsets), {}, ConstantLaw{0.98});
  ASSERT_EQ(chains.chains.size(), 1u);
  const auto& impacts = chains.chains[0].impacts;
  ASSERT_EQ(impacts.size(), 10u);
  const auto variance = [&](std::size_t k) { return square(0.5 * kDefaultGravity_mps2 * *onsets[k].sigma_t_s); };
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    // of the last two impacts only sums are known; all but these come out to rounding
    if (k + 3 > impacts.size()) continue;
    EXPECT_NEAR(impacts[k].timing, variance(k + 1), 1e-6 * variance(k + 1)) << k;
    EXPECT_NEAR(impacts[k].timing_before, variance(k), 1e-6 * variance(k)) << k;
    EXPECT_NEAR(impacts[k].timing_after, variance(k + 2), 1e-6 * variance(k + 2)) << k;
  }
}

TEST(Chains, CountWhatCameBefore) {
  const Chains chains = chains_of(samples_of(onsets_of(12)), {}, ConstantLaw{0.98});
  // the impact from the release, of 1.4 m/s, is no sample
  EXPECT_NEAR(chains.chains[0].s_before, square(1.98 * 1.4), 1e-9);
}

TEST(Chains, AreCutWhereASampleIsLeftOut) {
  RestitutionSamples samples = samples_of(onsets_of(30));
  const RestitutionSamples second = samples_of(onsets_of(20, 1));
  samples.insert(samples.end(), second.begin(), second.end());
  samples[40].flags.add(Flag::missing_impact);
  const Chains chains = chains_of(samples, {10}, ConstantLaw{0.98});
  ASSERT_EQ(chains.chains.size(), 4u);
  EXPECT_EQ(chains.n_drops, 2u);
  EXPECT_EQ(chains.n_impacts, samples.size() - 2);
  EXPECT_EQ(chains.chains[1].impacts.front().sample, 11u);
  EXPECT_EQ(chains.chains[1].drop, 0u);
  EXPECT_EQ(chains.chains[3].drop, 1u);
  // what came before the second piece: eleven impacts and the one of the release
  double sum = 0.0, v = 1.4;
  for (int k = 0; k < 12; ++k, v *= 0.98) sum += square(1.98 * v);
  EXPECT_NEAR(chains.chains[1].s_before, sum, 1e-6);
}

TEST(Chains, AreCutWhereSpeedsJump) {
  // two drops in a table that does not name them
  RestitutionSamples samples = samples_of(onsets_of(30));
  RestitutionSamples second = samples_of(onsets_of(20));
  for (RestitutionSample& s : second) s.impact += samples.back().impact;
  samples.insert(samples.end(), second.begin(), second.end());
  const Chains chains = chains_of(samples, {}, ConstantLaw{0.98});
  ASSERT_EQ(chains.chains.size(), 2u);
  EXPECT_EQ(chains.chains[1].impacts.size(), 18u);
}

TEST(Chains, LeaveOutTheFirstImpactOfABallAtRest) {
  RestitutionConfig config;
  config.drop_height_m = 0.1;
  const RestitutionSamples samples = restitution_samples(onsets_of(20), config).samples;
  ASSERT_EQ(samples.front().impact, 0);
  const Chains chains = chains_of(samples, {}, ConstantLaw{0.98});
  ASSERT_EQ(chains.chains.size(), 1u);
  EXPECT_EQ(chains.chains[0].impacts.size(), samples.size() - 1);
}

}  // namespace
}  // namespace bouncelab::fit
