// SPDX-License-Identifier: GPL-3.0-or-later
// The sampler for DEM codes against the simulator: what no p(eps|v) can reproduce.
#include "bouncelab/core/restitution_with_memory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/fluctuation.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/sim.hpp"
#include "drop_statistics.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"

namespace bouncelab::sim {
namespace {

constexpr std::int64_t kAsperities = 71'378;                               // constant radii: s2 = 2/N = 2.8e-5
constexpr double kQ = 5.0 / 7.0 * 2.0 / static_cast<double>(kAsperities);  // c = 5/7: a solid ball without slip
constexpr std::int64_t kBounces = 94;
constexpr double kWindow_mps = 0.6, kHalfWidth_mps = 0.05;

struct Bounce {
  std::int64_t drop;
  double v_mps, deviation;  ///< eps~ - eps(v)
};

struct Drops {
  std::vector<Bounce> bounces;
  std::vector<double> v_end_mps;  ///< of each drop, after 94 bounces

  /// Rising slope of the two exponentials at 0.6 m/s.
  testing::Estimate rising_slope() const {
    return testing::by_drop(20, [&](const std::function<bool(std::int64_t)>& counts) {
      std::vector<double> x;
      for (const Bounce& b : bounces)
        if (std::abs(b.v_mps - kWindow_mps) < kHalfWidth_mps && counts(b.drop)) x.push_back(b.deviation);
      std::sort(x.begin(), x.end());
      return 1.0 / testing::laplace(x).below;
    });
  }
};

Drops simulated(double height_m, double lowest_m, std::int64_t n_drops) {
  SimulationConfig config;
  config.drop_height_min_m = lowest_m;
  config.drop_height_max_m = height_m;
  config.n_drops = n_drops;
  config.n_impacts_max = kBounces + 1;
  config.n_threads = 1;
  const Surface surface = make_surface(config.ball, kAsperities, ConstantRadii{}, 1);
  Drops drops;
  for (const Impact& i : simulate(config, surface).impacts.rows) {
    drops.bounces.push_back({i.drop, i.v_mps, i.eps_macro - restitution(config.law, i.v_mps)});
    if (i.impact == kBounces) drops.v_end_mps.push_back(i.v_mps);
  }
  return drops;
}

Drops sampled(double height_m, double lowest_m, std::int64_t n_drops) {
  const SeriesLaw law;
  const auto eps = [&](double v_mps) { return restitution(law, v_mps); };
  Drops drops;
  for (std::int64_t drop = 0; drop < n_drops; ++drop) {
    Random random(7, RandomStream::test, static_cast<std::uint64_t>(drop));
    double v = std::sqrt(2.0 * kDefaultGravity_mps2 * random.uniform(lowest_m, height_m)), w = 0.0;
    for (std::int64_t k = 0; k < kBounces; ++k) {
      const double z1 = random.normal(), z2 = random.normal();
      const double e = restitution_with_memory(v, eps, kQ, z1, z2, w);
      drops.bounces.push_back({drop, v, e - eps(v)});
      v *= e;
    }
    drops.v_end_mps.push_back(v);
  }
  return drops;
}

/// Standard error of a standard deviation, with the fourth moment that the values have.
double se_of_sd(const std::vector<double>& x) {
  const double m = testing::mean(x), s = testing::sd(x);
  double fourth = 0.0;
  for (const double value : x) fourth += std::pow((value - m) / s, 4) / static_cast<double>(x.size());
  return 0.5 * s * std::sqrt((fourth - 1.0) / static_cast<double>(x.size()));
}

void expect_same(const Drops& a, const Drops& b) {
  const double n = 1.0 / static_cast<double>(a.v_end_mps.size()), m = 1.0 / static_cast<double>(b.v_end_mps.size());
  const double sd_a = testing::sd(a.v_end_mps), sd_b = testing::sd(b.v_end_mps);
  // four standard errors each: one such comparison in 16,000 fails at random
  EXPECT_NEAR(testing::mean(a.v_end_mps), testing::mean(b.v_end_mps),
              4.0 * std::sqrt(sd_a * sd_a * n + sd_b * sd_b * m));
  EXPECT_NEAR(sd_a, sd_b, 4.0 * std::hypot(se_of_sd(a.v_end_mps), se_of_sd(b.v_end_mps)));
  const testing::Estimate slope_a = a.rising_slope(), slope_b = b.rising_slope();
  EXPECT_NEAR(slope_a.value, slope_b.value, 4.0 * std::hypot(slope_a.se, slope_b.se));
}

TEST(RestitutionWithMemory, ReproducesTheSimulatedDropsFromOneHeightAndFromSeveral) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const auto n = test::repetitions<std::int64_t>(300, 1500);
  expect_same(simulated(0.1, 0.09, n), sampled(0.1, 0.09, 4 * n));
  if (n < 1000) return;
  expect_same(simulated(0.1, 0.1, n), sampled(0.1, 0.1, 4 * n));
  expect_same(simulated(1.0, 1.0, n), sampled(1.0, 1.0, 4 * n));
}

}  // namespace
}  // namespace bouncelab::sim
