// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/theory.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/loop/closed_loop.hpp"
#include "short_loop.hpp"

namespace bouncelab::loop {
namespace {

/// A simulation and its exact times, each the match of itself.
struct ExactTimes {
  Impacts impacts;
  std::vector<sim::Reservoir> reservoirs;
  Onsets onsets;
  std::vector<std::optional<std::size_t>> match;
  fit::FitResult fitted;  ///< the law that went in
  RestitutionSamples samples() const { return fit::restitution_samples(onsets, {}).samples; }
  std::optional<ReservoirCheck> check() const {
    return reservoir_check(impacts, reservoirs, onsets, onsets, match, samples(), fitted, kDefaultGravity_mps2);
  }
};

ExactTimes exact_times(const sim::ContactModel& contact, std::int64_t n_drops = 20) {
  sim::SimulationConfig config;
  config.contact = contact;
  config.n_drops = n_drops;
  config.n_impacts_max = 60;
  config.n_threads = 2;
  config.with_state = true;
  constexpr std::int64_t kAsperities = 71'378;  // of one radius: q = 2e-5 without slip
  ExactTimes exact;
  exact.impacts =
      sim::simulate(config, sim::make_surface(config.ball, kAsperities, sim::ConstantRadii{1e-3}, 3)).impacts;
  exact.reservoirs = sim::reservoirs_after(config.ball, exact.impacts);
  for (const Impact& impact : exact.impacts.rows) {
    Onset onset;
    onset.recording = "drop " + std::to_string(impact.drop);
    onset.drop = impact.drop;
    onset.impact = impact.impact;
    onset.t_s = impact.t_s;
    exact.match.emplace_back(exact.onsets.size());
    exact.onsets.push_back(std::move(onset));
  }
  exact.fitted.law.law = config.law;
  return exact;
}

/// Terms of second order in the offset, which the balance of energy leaves out, are some q w/v^2 and theta^2 of the
/// reservoir for each of 60 impacts: below 1 % of it.
void expect_agreement(const ReservoirCheck& check) {
  EXPECT_GT(check.correlation, 0.9999);
  EXPECT_LT(check.rms_difference_m2ps2, 2.0 * check.expected_offset_m2ps2 + 0.01 * check.rms_simulated_m2ps2);
  EXPECT_EQ(check.expected_timing_m2ps2, 0.0);
}

TEST(ReservoirChecks, OnExactTimesFindTheEnergyOfSpinAndSidewaysMotion) {
  const auto check = exact_times(sim::PaperContact{}).check();
  ASSERT_TRUE(check);
  ASSERT_EQ(check->drops.size(), 20u);
  EXPECT_EQ(check->drops[3].drop, 3);
  EXPECT_EQ(check->drops[3].first_impact, 1);  // before the first impact there is no interval, after the last none
  EXPECT_EQ(check->drops[3].last_impact, 58);
  expect_agreement(*check);
  EXPECT_NEAR(check->spin_share, 2.0 / 7.0, 0.01);  // rolling, to first order in the offsets, 1e-2
}

TEST(ReservoirChecks, WithoutFrictionFindSpinAlone) {
  const auto check = exact_times(sim::FrictionlessContact{}).check();
  ASSERT_TRUE(check);
  expect_agreement(*check);
  EXPECT_EQ(check->spin_share, 1.0);
}

TEST(ReservoirChecks, SeeAnotherLawAsItsError) {
  ExactTimes exact = exact_times(sim::PaperContact{}, 5);
  const auto right = exact.check();
  SeriesLaw law;
  law.a[5] += 0.01;
  exact.fitted.law.law = law;
  const auto wrong = exact.check();
  ASSERT_TRUE(right && wrong);
  double expected = 0.0;  // 2 v^2 d eps at each impact
  for (const Impact& impact : exact.impacts.rows)
    if (impact.impact >= 1 && impact.impact <= 58)
      expected += 2.0 * impact.v_mps * impact.v_mps * kViscoelasticC[5] * 0.01 * std::sqrt(impact.v_mps) / 5.0;
  // to first order in 1 - eps and v eps', some 2 % each
  EXPECT_NEAR(wrong->mean_difference_m2ps2 - right->mean_difference_m2ps2, expected, 0.05 * expected);
}

TEST(ReservoirChecks, TakeTheLongestStretchWithoutAMissingImpact) {
  ExactTimes exact = exact_times(sim::PaperContact{}, 3);
  const Onsets truth = exact.onsets;
  exact.onsets.erase(exact.onsets.begin() + 20);  // impact 20 of drop 0 is not detected
  for (std::size_t k = 20; k < 59; ++k)
    exact.onsets[k].impact = static_cast<std::int64_t>(k);  // as a detector numbers them
  exact.match.clear();
  for (std::size_t k = 0; k < truth.size(); ++k)
    exact.match.push_back(k == 20 ? std::nullopt : std::optional(k < 20 ? k : k - 1));
  const auto check = reservoir_check(exact.impacts, exact.reservoirs, truth, exact.onsets, exact.match, exact.samples(),
                                     exact.fitted, kDefaultGravity_mps2);
  ASSERT_TRUE(check);
  ASSERT_EQ(check->drops.size(), 3u);
  EXPECT_GT(check->drops[0].first_impact, 20);
  EXPECT_EQ(check->drops[0].last_impact, 58);
  expect_agreement(*check);
}

TEST(ReservoirChecks, SayNothingOfTwoDropsOrOfASmoothBall) {
  EXPECT_FALSE(exact_times(sim::PaperContact{}, 2).check());
  ExactTimes smooth = exact_times(sim::PaperContact{}, 3);
  for (sim::Reservoir& reservoir : smooth.reservoirs) reservoir = {};
  EXPECT_FALSE(smooth.check());
  ExactTimes no_law = exact_times(sim::PaperContact{}, 3);
  no_law.fitted.law.law.reset();
  EXPECT_FALSE(no_law.check());
}

TEST(ReservoirChecks, ThroughSoundDifferByWhatTheLawIsUncertain) {
  LoopConfig config = short_loop(12, 60);
  config.n_asperities = 71'378;
  config.radius_law = sim::ConstantRadii{1e-3};
  const LoopResult loop = run_loop(config);
  ASSERT_TRUE(loop.reservoir);
  const ReservoirCheck& check = *loop.reservoir;
  EXPECT_FALSE(check.with_memory);
  EXPECT_EQ(check.drops.size(), 12u);
  ASSERT_TRUE(check.expected_law_m2ps2);
  // the law's error is one number for all drops, so the difference is one draw: 4 standard errors, with those of
  // the drops' own, and 1 % as on exact times
  const double own = std::hypot(check.expected_timing_m2ps2, check.expected_offset_m2ps2);
  EXPECT_LT(check.rms_difference_m2ps2, 4.0 * std::hypot(*check.expected_law_m2ps2, own));
  // and it moves all drops alike: what remains is their own error and 1 % of the reservoir, as on exact times, and a
  // fifth of the shift, for drops fall from 9 to 10 cm and some are slowed down more than others
  const double about_mean =
      std::sqrt(std::max(0.0, std::pow(check.rms_difference_m2ps2, 2) - std::pow(check.mean_difference_m2ps2, 2)));
  EXPECT_LT(about_mean, 2.0 * own + 0.01 * check.rms_simulated_m2ps2 + 0.2 * std::abs(check.mean_difference_m2ps2));
  EXPECT_GT(check.correlation, 0.99);
}

}  // namespace
}  // namespace bouncelab::loop
