// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/goodness.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/random.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using testing::independent_samples;
using testing::Scatter;
using testing::SyntheticRun;

TEST(AndersonDarling, OfEvenlySpacedTransformsIsSmallAndOfOneIsByHand) {
  // n = 1, u = 1/2: -1 - (log 1/2 + log 1/2) = 0.386294
  EXPECT_NEAR(anderson_darling({0.5}), 2.0 * std::log(2.0) - 1.0, 1e-12);
  // n = 2, u = 1/4, 3/4: -2 - (2 log 1/4 + 6 log 3/4) / 2
  EXPECT_NEAR(anderson_darling({0.75, 0.25}), -2.0 - std::log(0.25) - 3.0 * std::log(0.75), 1e-12);
}

LawFitConfig tested(std::size_t n_replicates) {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  config.n_goodness = n_replicates;
  return config;
}

TEST(AndersonDarling, PValuesOfTheRightModelAreUniform) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const int n_seeds = test::repetitions(15, 60);  // against 39 replicates each
  double mean = 0.0;
  int n_low = 0;
  for (int seed = 1; seed <= n_seeds; ++seed) {
    SyntheticRun run;
    run.seed = static_cast<std::uint64_t>(seed);
    const auto fit = fit_law(independent_samples(run, 400, 0.2, 1.4, 3e-4), tested(39));
    ASSERT_TRUE(fit.anderson_darling);
    mean += fit.anderson_darling->p_value / n_seeds;
    n_low += fit.anderson_darling->p_value <= 0.25;
  }
  EXPECT_NEAR(mean, 0.5, 3.5 / std::sqrt(12.0 * n_seeds));  // of a uniform number: sd 1/sqrt(12)
  EXPECT_GE(n_low, test::fewest_of(n_seeds, 0.25));
  EXPECT_LE(n_low, test::most_of(n_seeds, 0.25));
}

TEST(AndersonDarling, RejectsAScatterOfAnotherShape) {
  // a uniform distribution: no tails at all
  RestitutionSamples samples = independent_samples({}, 4000, 0.2, 1.4, 0.0);
  Random random(1, RandomStream::test, 99);
  for (RestitutionSample& s : samples) s.eps = restitution(SeriesLaw{}, s.v_mps) + random.uniform(-2e-3, 2e-3);
  const auto fit = fit_law(samples, tested(49));
  EXPECT_DOUBLE_EQ(fit.anderson_darling->p_value, 1.0 / 50.0);  // none of 49 replicates lies so far off
}

}  // namespace
}  // namespace bouncelab::fit
