// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/memory_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/theory.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"

namespace bouncelab::loop {
namespace {

/// A few drops on a surface of few asperities.
MemoryConditions small_conditions(std::uint64_t seed) {
  MemoryConditions c;
  c.radius_law = sim::ConstantRadii{};
  c.n_asperities = 60'000;
  c.n_drops = 3;
  c.q = 5.0 / 7.0 * 2.0 / 60'000.0;  // constant radii, no slip: docs/physics.md, 7
  c.seed = seed;
  return c;
}

const MemoryCalibrationGroup& group_named(const std::vector<MemoryCalibrationGroup>& groups, const std::string& family,
                                          const std::string& name) {
  for (const MemoryCalibrationGroup& g : groups)
    if (g.family == family && g.name == name) return g;
  throw InvalidArgument("no group " + family + " " + name);
}

TEST(MemoryCalibration, DrawsConditionsInTheLinearRegimeAndMeetsEveryRadiusLawWithEveryContact) {
  MemoryCalibrationConfig config;
  std::set<std::pair<std::size_t, std::string>> met;
  std::size_t n_drag = 0, n_sound = 0, n_spin = 0;
  for (std::size_t k = 0; k < 30; ++k) {
    const MemoryConditions c = memory_conditions(config, k);
    met.insert({c.radius_law.index(), describe(c.contact)});
    const sim::ContactOffset offset = contact_offset(c.radius_law, static_cast<double>(c.n_asperities));
    EXPECT_NEAR(c.q, sim::contact_factor(Ball{}, c.contact) * offset.variance, 1e-9 * c.q);
    EXPECT_GE(c.q, 1e-7);
    EXPECT_LE(c.q, 7.01e-5);  // the limit; bisection ends within 1e-5 of it
    EXPECT_LE(offset.smooth_share, 1.01e-3);
    EXPECT_GE(c.n_asperities, 30'000);
    EXPECT_LE(c.n_asperities, 10'000'000);
    EXPECT_GE(c.n_drops, 5);
    EXPECT_LE(c.n_drops, 100);
    n_drag += c.drag;
    n_sound += c.sound;
    n_spin += c.release_spin_radps > 0.0;
  }
  EXPECT_EQ(met.size(), 30U);
  // halves of 30 within four standard deviations, 11; a quarter: some, and not all
  EXPECT_NEAR(static_cast<double>(n_drag), 15.0, 11.0);
  EXPECT_NEAR(static_cast<double>(n_sound), 15.0, 11.0);
  EXPECT_GE(n_spin, 1U);
  EXPECT_LE(n_spin, 17U);
  EXPECT_EQ(memory_conditions(config, 7).seed, memory_conditions(config, 7).seed);
  EXPECT_NE(memory_conditions(config, 7).seed, memory_conditions(config, 8).seed);
}

TEST(MemoryCalibration, RefusesWhatCannotBeDrawn) {
  MemoryCalibrationConfig config;
  config.n_drops_min = 9;
  config.n_drops_max = 8;
  EXPECT_THROW(memory_conditions(config, 0), InvalidArgument);
  config = {};
  config.n_impacts = 11;
  EXPECT_THROW(calibrate_memory(config), InvalidArgument);
  config = {};
  config.n_experiments = 0;
  EXPECT_THROW(calibrate_memory(config), InvalidArgument);
}

TEST(MemoryCalibration, FindsTheTruthThatWentInAndItsTablesAddUp) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  MemoryConditions in_air = small_conditions(1);
  in_air.drag = true;
  MemoryConditions by_sound = small_conditions(3);
  by_sound.sound = true;
  const auto n_impacts = test::repetitions<std::int64_t>(60, 96);
  std::vector<MemoryExperiment> experiments;
  for (const MemoryConditions& c : {in_air, by_sound}) experiments.push_back(run_memory_experiment(c, n_impacts));
  for (const MemoryExperiment& e : experiments) {
    ASSERT_EQ(e.status, fit::FitStatus::ok);
    EXPECT_GE(static_cast<std::int64_t>(e.n_used), 3 * (n_impacts - 2) - 6);  // two samples go with each impact missed
    EXPECT_EQ(e.quantities.size(), 7U);
    for (const CalibratedQuantity& q : e.quantities) {
      ASSERT_TRUE(q.with_memory && q.with_memory->se) << q.name;
      // 14 correlated numbers of fixed seeds: 5 standard errors, since with 3 drops the posterior is no normal one
      EXPECT_LT(std::abs(q.with_memory->value - q.truth), 5.0 * *q.with_memory->se) << q.name;
      // of three drops the independent fit need not know all constants
      const bool expected = q.name.starts_with("eps") || (q.name != "q" && q.independent);
      EXPECT_EQ(q.independent.has_value(), expected) << q.name;
    }
    EXPECT_EQ(e.quantities.back().truth, e.conditions.q);
  }

  const std::vector<MemoryCalibrationGroup> groups = memory_calibration_groups(experiments);
  std::map<std::string, std::size_t> n, n_holds;
  for (const MemoryCalibrationGroup& g : groups) {
    n[g.family] += g.n;
    n_holds[g.family] += g.n_holds;
    EXPECT_LE(g.n_failed + g.n_holds, g.n);
  }
  const std::size_t holds = group_named(groups, "test", "passed").n;
  for (const char* family : {"model", "radii", "contact", "release", "drag", "times", "drops"}) {
    EXPECT_EQ(n[family], 2U) << family;
    EXPECT_EQ(n_holds[family], holds) << family;
  }
  EXPECT_EQ(group_named(groups, "times", "from sound").n, 1U);
  EXPECT_EQ(group_named(groups, "drag", "on").n, 1U);

  // the first row once more, by hand
  const MemoryCalibrationRow& row = group_named(groups, "test", "any").rows.front();
  double pull = 0.0, error2 = 0.0, independent2 = 0.0;
  for (const MemoryExperiment& e : experiments) {
    const CalibratedQuantity& q = e.quantities.front();
    pull += (q.with_memory->value - q.truth) / *q.with_memory->se / 2.0;
    error2 += std::pow(q.with_memory->value - q.truth, 2);
    independent2 += std::pow(q.independent->value - q.truth, 2);
  }
  EXPECT_EQ(row.quantity, "eps_025");
  EXPECT_EQ(row.n, 2U);
  EXPECT_NEAR(*row.pull_mean, pull, 1e-9);  // rounding
  EXPECT_NEAR(*row.gain, independent2 / error2, 1e-9 * *row.gain);

  const Table table = to_table(experiments);
  EXPECT_EQ(table.n_rows(), 2U);
  ASSERT_TRUE(table.reals("eps_025") && table.reals("se_eps_025") && table.reals("eps_025_truth"));
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(table.reals("eps_025")->at(k), experiments[k].quantities.front().with_memory->value);
}

TEST(MemoryCalibration, CountsAFitThatCouldNotBeMadeAndIsTheSameOnAnyNumberOfThreads) {
  MemoryCalibrationConfig config;
  config.n_experiments = 2;
  config.n_drops_min = config.n_drops_max = 1;  // of 12 impacts: too few
  config.n_impacts = 12;
  config.n_threads = 1;
  // millions of asperities take long to draw
  const auto large = [&](std::size_t k) { return memory_conditions(config, k).n_asperities > 1'000'000; };
  while ((large(0) || large(1)) && config.seed < 1000) ++config.seed;
  const std::vector<MemoryExperiment> one = calibrate_memory(config);
  const MemoryCalibrationGroup any = memory_calibration_groups(one).front();
  EXPECT_EQ(any.n, 2U);
  EXPECT_EQ(any.n_failed, 2U);
  EXPECT_TRUE(any.rows.empty());
  EXPECT_FALSE(one.front().objections.empty());
  config.n_threads = 2;
  double last = 0.0;
  const std::vector<MemoryExperiment> two = calibrate_memory(config, [&](double done, double) { last = done; });
  EXPECT_EQ(last, 2.0);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(one[k].conditions.seed, two[k].conditions.seed);
    ASSERT_EQ(one[k].quantities[0].independent.has_value(), two[k].quantities[0].independent.has_value());
    if (!one[k].quantities[0].independent) continue;
    EXPECT_EQ(one[k].quantities[0].independent->value, two[k].quantities[0].independent->value);
  }
}

}  // namespace
}  // namespace bouncelab::loop
