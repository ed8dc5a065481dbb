// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/error_budget.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

ErrorBudget budget_of(const testing::SyntheticRun& run, const std::optional<Ball>& ball = {},
                      const std::optional<Material>& plate = {}) {
  LawFit truth;
  truth.law = run.law;
  truth.scatter = ScatterModel{1.0, {std::log(run.below_at_1mps), -1.0}, {std::log(run.above_at_1mps), -1.0}};
  BudgetConfig config;
  config.ball = ball;
  config.plate = plate;
  return error_budget(restitution_samples(synthetic_onsets(run), {}).samples, truth, config);
}

TEST(ErrorBudget, FindsTheTimingNoiseFromNeighboursWithoutBeingTold) {
  for (const double sigma_s : {3e-6, 1e-5, 1e-4}) {
    testing::SyntheticRun run;
    run.timing_sigma_s = sigma_s;
    const auto timing = budget_of(run).timing;
    ASSERT_TRUE(timing);
    EXPECT_NEAR((timing->variance_s2 - sigma_s * sigma_s) / timing->variance_se_s2, 0.0, 4.0) << sigma_s;
    EXPECT_NEAR(*timing->stated_s / sigma_s, 1.0, 1e-3);
  }
}

TEST(ErrorBudget, IsForWhatTheSamplesSayOfThemselves) {
  RestitutionConfig config;
  config.air_kgpm3 = 0.0;
  config.gravity_mps2 = 1.62;
  config.ball = ball_from_text("glass:8mm");
  config.plate = kGlass;
  config.wave_speed_mps = 343.0;
  const RestitutionSamples samples = restitution_samples(testing::synthetic_onsets({}), config).samples;
  BudgetConfig base;
  base.has_travel_time = false;
  const BudgetConfig budget = budget_config_of(samples, base);
  EXPECT_FALSE(budget.has_drag);
  EXPECT_TRUE(budget.has_contact_time);
  EXPECT_FALSE(budget.has_travel_time);
  EXPECT_EQ(budget.gravity_mps2, 1.62);
  EXPECT_EQ(budget.ball, config.ball);
  EXPECT_EQ(budget.plate, kGlass);
  EXPECT_EQ(budget.wave_speed_mps, 343.0);
  // of samples that say nothing it is as configured
  base.ball = config.ball;
  base.has_drag = false;
  const BudgetConfig as_configured = budget_config_of(testing::independent_samples({}, 100, 0.2, 1.4, 0.0), base);
  EXPECT_EQ(as_configured.ball, base.ball);
  EXPECT_FALSE(as_configured.has_drag);
  EXPECT_TRUE(as_configured.has_contact_time);
}

TEST(ErrorBudget, LagOneIsMinusTwoThirdsOfTimingAndZeroOfAsperities) {
  testing::SyntheticRun run;
  const auto none = budget_of(run).timing;
  EXPECT_NEAR(none->lag1_correlation, 0.0, 4.0 * none->lag1_correlation_se);
  EXPECT_LT(none->lag1_correlation_se, 0.05);
  run.timing_sigma_s = 1e-4;
  run.below_at_1mps = run.above_at_1mps = 1e-6;
  const auto all = budget_of(run).timing;
  EXPECT_NEAR(all->lag1_correlation, -2.0 / 3.0, 4.0 * all->lag1_correlation_se);
}

TEST(ErrorBudget, SpreadsAddInSquares) {
  testing::SyntheticRun run;
  run.timing_sigma_s = 1e-5;
  run.n_drops = 80;
  const auto budget = budget_of(run);
  ASSERT_EQ(budget.rows.size(), 12u);
  for (const auto& row : budget.rows) {
    const double expected = std::hypot(*row.spread_asperities, *row.spread_timing_stated);
    // about 630 samples a row, kurtosis up to 6: 4.5 % standard error of the spread; the width changes within the row
    EXPECT_NEAR(row.spread / expected, 1.0, 0.18) << row.v_mps;
  }
  // both parts go as 1/v
  EXPECT_NEAR(budget.width_exponent->value, -1.0, 4.0 * *budget.width_exponent->se + 0.02);
}

TEST(ErrorBudget, ShiftsAreThoseOfPhysics) {
  // -kappa v^2 (1 + eps^2)/(4 g): as v^1.5 while C_d falls with speed, -3.3e-4 at .7 m/s, within 15 %
  testing::SyntheticRun run;
  for (const auto& row : budget_of(run, Ball{}, kGlass).rows) {
    EXPECT_NEAR(*row.shift_drag / (-3.3e-4 * std::pow(row.v_mps / 0.7, 1.5)), 1.0, 0.15) << row.v_mps;
    EXPECT_LT(std::abs(*row.shift_contact_time), 5e-5);
    EXPECT_GT(std::abs(*row.shift_contact_time), 1e-7);
  }
}

TEST(ErrorBudget, WithoutABallShiftsAreNotKnown) {
  const testing::SyntheticRun run;
  for (const auto& row : budget_of(run).rows) EXPECT_TRUE(!row.shift_drag && !row.shift_contact_time);
  const Ball shell = ball_from_text("table-tennis");
  const auto of_shell = budget_of(run, shell, kGlass).rows, of_steel = budget_of(run, Ball{}, kGlass).rows;
  for (std::size_t k = 0; k < of_shell.size(); ++k) {
    const BudgetRow& row = of_shell[k];
    const double drag = drag_per_m(shell, {}, row.v_mps) / drag_per_m({}, {}, row.v_mps);
    // proportional to the drag, but for its growth with speed, which is a little faster where Re is larger
    EXPECT_NEAR(*row.shift_drag / *of_steel[k].shift_drag / drag, 1.0, 0.06);
    // .8 ms by the catalogue, of intervals of 40 ms and more: as below
    EXPECT_LT(*row.shift_contact_time, 0.02 * (1.0 - restitution(run.law, row.v_mps)));
    EXPECT_GT(*row.shift_contact_time, 0.0);
  }
  // a contact of constant duration tau adds tau to both intervals T and eps T: eps moves by (1 - eps) tau / T
  const auto measured = budget_of(run, ball_from_text("table-tennis,contact-time=0.8ms")).rows;
  for (const auto& row : measured) {
    const double eps = restitution(run.law, row.v_mps), interval_s = 2.0 * row.v_mps / 9.81;
    EXPECT_NEAR(*row.shift_contact_time, (1.0 - eps) * 0.8e-3 / (interval_s + 0.8e-3), 1e-12);  // rounding
  }
}

TEST(ErrorBudget, SharesAddToOneAndTellTheBallFromTheClock) {
  testing::SyntheticRun run;
  run.timing_sigma_s = 1e-5;
  run.n_drops = 80;
  for (const auto& row : budget_of(run).rows) {
    EXPECT_NEAR(row.share_asperities + row.share_timing + row.share_travel_time + row.share_unexplained, 1.0, 1e-12);
    // both sides of the ratio go as 1/v^2: (4e-4^2 + 3e-4^2) to (s g sqrt(6)/2)^2 = 1.44e-8 at 1 m/s
    EXPECT_NEAR(row.share_timing / row.share_asperities, 1.44e-8 / 2.5e-7, 0.004);
    EXPECT_LT(row.share_unexplained, 0.3);
  }
}

TEST(ErrorBudget, WhatIsAbsentShiftsNothing) {
  testing::SyntheticRun run;
  LawFit truth;
  truth.law = run.law;
  BudgetConfig config;
  config.has_drag = config.has_contact_time = config.has_travel_time = false;
  const auto budget = error_budget(restitution_samples(synthetic_onsets(run), {}).samples, truth, config);
  for (const auto& row : budget.rows)
    EXPECT_TRUE(row.shift_drag == 0.0 && row.shift_contact_time == 0.0 && row.spread_travel_time == 0.0);
}

TEST(ErrorBudget, WithoutALawIsEmpty) {
  EXPECT_TRUE(error_budget(testing::independent_samples({}, 50, 0.2, 1.4, 0.0), {}, {}).rows.empty());
}

}  // namespace
}  // namespace bouncelab::fit
