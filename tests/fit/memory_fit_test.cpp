// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/error.hpp"
#include "support/sanitizers.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using Drops = testing::RoughDrops;
using testing::rough_drops;

struct Fits {
  LawFit independent;
  MemoryFit memory;
};

Fits fitted(const RestitutionSamples& samples, std::size_t n_draws = 150, std::size_t n_goodness = 0) {
  LawFitConfig law;
  law.intervals = IntervalMethod::covariance;
  law.node_speeds_mps = {0.6, 1.2};
  Fits fits;
  fits.independent = fit_law(samples, law);
  MemoryFitConfig config;
  config.n_draws = n_draws;
  config.n_goodness = n_goodness;
  fits.memory = fit_memory(samples, fits.independent, config);
  return fits;
}

double z_of(const Estimate& e, double truth) { return (e.value - truth) / *e.se; }

TEST(MemoryFit, FindsWhatWentIn) {
  Drops drops;
  drops.timing_s = 2e-7;
  const auto [independent, fit] = fitted(rough_drops(drops, 1), 300, 9);
  ASSERT_EQ(fit.status, FitStatus::ok);
  for (std::size_t k = 0; k < fit.nodes.size(); ++k) {
    const NodeEstimate& node = fit.nodes[k];
    EXPECT_LT(std::abs(z_of(node.eps, restitution(SeriesLaw{}, node.v_mps))), 4.0);
    // of long drops ten times less than of independent samples; these are of sixty impacts, and of fast ones their
    // place in the drop, which independent samples have as well, says as much
    const double most = k + 1 < fit.nodes.size() ? 0.25 : 0.6;
    EXPECT_LT(*node.eps.se, most * independent.nodes[k].eps.se_independent.value());
    EXPECT_LT(node.eps.ci95->lo, node.eps.value);
    EXPECT_GT(node.eps.ci95->hi, node.eps.value);
  }
  EXPECT_LT(std::abs(z_of(fit.roughness.q, 2e-5)), 4.0);
  EXPECT_LT(*fit.roughness.q.se, 0.1 * fit.roughness.q.value);
  EXPECT_LT(std::abs(fit.leak.z), 4.0);
  EXPECT_LT(std::abs(fit.mechanism.z), 4.0);
  EXPECT_LT(std::abs(fit.release.z), 4.0);
  EXPECT_TRUE(fit.holds);
  EXPECT_GT(fit.loglik, *fit.loglik_independent);
}

TEST(MemoryFit, PullsAreThoseOfAStandardNormal) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  double sum = 0.0;
  constexpr int kSets = 6;
  Drops drops;
  drops.n = 5;
  drops.impacts = 40;
  drops.timing_s = 2e-7;
  for (int set = 0; set < kSets; ++set) {
    const MemoryFit fit = fitted(rough_drops(drops, 100 + static_cast<std::uint64_t>(set))).memory;
    ASSERT_EQ(fit.status, FitStatus::ok);
    const double z = z_of(fit.nodes[0].eps, restitution(SeriesLaw{}, 0.6));
    sum += z * z;
  }
  // chi-square of 6 degrees of freedom: outside these once in 5,000 on either side; a standard error that is twice too
  // small or large would be seen in eight of ten
  EXPECT_LT(sum, 26.0);
  EXPECT_GT(sum, 0.3);
}

TEST(MemoryFit, SeesALeak) {
  Drops drops;
  drops.n = 6;
  drops.kept = 0.97;
  const MemoryFit fit = fitted(rough_drops(drops, 2)).memory;
  ASSERT_EQ(fit.status, FitStatus::ok);
  EXPECT_LT(std::abs(z_of(fit.keep, 0.97)), 4.0);
  EXPECT_LT(fit.leak.p_value, 0.01);
}

TEST(MemoryFit, WhatTheReleaseGaveIsNotTakenForARougherBall) {
  struct Case {
    double release;
    bool same;
    double slips;
  };
  // mean reservoirs of drops of their own; 20 rad/s and some of a 3 mm ball in each, thirty times what the first impact
  // adds, without slip and with it
  for (const Case& c : {Case{5e-3, false, 0.0}, Case{9e-3, true, 0.0}, Case{5e-3, false, 0.4}}) {
    SCOPED_TRACE(c.release + c.slips);
    Drops drops;
    drops.timing_s = 2e-7;
    drops.release = c.release;
    drops.same = c.same;
    drops.slips = c.slips;
    const MemoryFit fit = fitted(rough_drops(drops, 8)).memory;
    ASSERT_EQ(fit.status, FitStatus::ok);
    for (const NodeEstimate& node : fit.nodes)
      EXPECT_LT(std::abs(z_of(node.eps, restitution(SeriesLaw{}, node.v_mps))), 4.0);
    EXPECT_LT(std::abs(z_of(fit.roughness.q, drops.q)), 4.0);
    if (c.slips > 0.0) {
      EXPECT_LT(std::abs(z_of(fit.keep, 1.0)), 4.0);
    } else if (c.same) {
      EXPECT_LT(fit.release.p_value, 1e-3);
    } else {
      ASSERT_TRUE(fit.release_m2ps2);
      // twelve exponential variables: their mean is known to .29
      EXPECT_GT(fit.release_m2ps2->value, 1.5e-3);
      EXPECT_LT(fit.release_m2ps2->value, 2e-2);
    }
  }
}

TEST(MemoryFit, ScatterThatDoesNotRememberFailsItsTest) {
  Drops drops;
  drops.n = 6;
  drops.memory = false;
  const MemoryFit fit = fitted(rough_drops(drops, 3)).memory;
  EXPECT_FALSE(fit.holds);
  EXPECT_FALSE(fit.objections.empty());
}

/// 1/(1 + replicates), what a test by drawing says at least, is then at its limit.
constexpr std::size_t kEnoughReplicates = 99;

TEST(MemoryFit, ABallThatIsRougherForSlowImpactsFailsItsTest) {
  Drops drops;
  drops.power = -1.2;  // that of offsets averaged over Hertz' patch
  const MemoryFit fit = fitted(rough_drops(drops, 13), 150, kEnoughReplicates).memory;
  ASSERT_EQ(fit.status, FitStatus::ok);
  EXPECT_LT(fit.by_speed.z, -2.5);
  EXPECT_FALSE(fit.holds);
  EXPECT_EQ(fit.objections.front().kind, NoteKind::memory_by_speed);
}

TEST(MemoryFit, DropsThatDifferAreSeenInTheirScores) {
  Drops drops;
  drops.impacts = 92;
  const auto ratio = [&](std::uint64_t seed) {
    const MemoryFit fit = fitted(rough_drops(drops, seed), 60, 1).memory;
    return fit.between_drops ? fit.between_drops->ratio : 0.0;
  };
  // mean of 8 chi-squares of 11 degrees of freedom over 11: standard deviation .15 and, scores not being normal, more
  EXPECT_NEAR(ratio(17), 1.0, 0.6);
  drops.spread = 0.003;  // some 1e-4 of eps
  EXPECT_GT(ratio(17), 1.8);
}

TEST(MemoryFit, WithOneConstantAndWithGamma) {
  const RestitutionSamples samples = rough_drops({}, 4);
  const LawFit independent = fit_law(samples, {});
  MemoryFitConfig config;
  config.kind = LawKind::viscoelastic;
  config.n_draws = 100;
  config.n_goodness = 0;
  const MemoryFit fit = fit_memory(samples, independent, config);
  ASSERT_EQ(fit.status, FitStatus::ok);
  ASSERT_EQ(fit.parameters.size(), 1u);
  EXPECT_EQ(fit.parameters[0].name, "gamma");
  // the gamma that reproduces the paper's fit to 3.7e-4 rms of 1 - eps = .02
  EXPECT_NEAR(fit.parameters[0].estimate.value, 0.02072, 0.02 * 0.02072);
}

TEST(MemoryFit, SaysWhatItNeeds) {
  const RestitutionSamples samples = rough_drops({2, 12}, 6);
  const MemoryFit fit = fit_memory(samples, fit_law(samples, {}), {});
  EXPECT_EQ(fit.status, FitStatus::too_few_samples);
  EXPECT_EQ(fit.objections.at(0).kind, NoteKind::memory_too_few);
  MemoryFitConfig config;
  config.orders = {2, 4, 5, 6, 7, 8};
  EXPECT_THROW(fit_memory(samples, fit_law(samples, {}), config), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::fit
