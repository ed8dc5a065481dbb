// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "support/refusal.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using ::testing::StartsWith;

TEST(FitAll, OfTheQuickLoopKnowsTheCurveAndItsSlopes) {
  testing::SyntheticRun run;
  run.timing_sigma_s = 3e-6;
  RestitutionConfig no_air;
  no_air.air_kgpm3 = 0.0;
  no_air.instant_contacts = true;
  const auto restitution_result = restitution_samples(synthetic_onsets(run), no_air);
  EXPECT_EQ(restitution_result.samples.size(), 40u * 95u);
  const auto result = fit_all(restitution_result.samples, {});
  ASSERT_TRUE(result.curve && result.law.law);
  for (const auto& node : result.law.nodes)
    EXPECT_LT(std::abs(node.eps.value - restitution(run.law, node.v_mps)), 4.5 * *node.eps.se) << node.v_mps;
  // two exponentials about the peak: the mean is off by the difference of their means, each has a variance of its
  // mean's square
  ASSERT_EQ(result.curve->nodes.size(), 3u);
  for (const auto& node : result.curve->nodes) {
    const double below = mean_below(run, node.v_mps), above = mean_above(run, node.v_mps);
    const double truth = std::hypot(restitution(run.law, node.v_mps) + above - below, std::hypot(below, above));
    EXPECT_LT(std::abs(node.eps.value - truth), 4.5 * *node.eps.se) << node.v_mps;
  }
  EXPECT_FALSE(result.constants.gamma) << "no viscoelastic sphere has the law that went in";
  EXPECT_EQ(result.histograms.size(), 8u);
}

TEST(FitAll, WhatDragLeavesOpenIsInErrorsAndCovariancesAlikeWithAndWithoutMemory) {
  testing::SyntheticRun run;
  run.timing_sigma_s = 3e-6;
  run.n_drops = 8;
  run.n_impacts = 50;
  RestitutionSamples in_air = restitution_samples(synthetic_onsets(run), {}).samples;
  for (RestitutionSample& s : in_air) s.conditions.ball = Ball{};  // known, so that a world without air is none
  FitConfig config;
  config.n_goodness = 0;
  config.memory = UseMemory::always;
  const FitResult result = fit_all(in_air, config);
  ASSERT_TRUE(result.curve && result.curve->kappa_per_m && *result.curve->kappa_per_m->se > 0.0);
  const Estimate& kappa = *result.curve->kappa_per_m;  // log-normal
  EXPECT_NEAR(std::log(kappa.ci95->hi / kappa.ci95->lo) / std::log(kappa.ci68->hi / kappa.ci68->lo), 1.96, 1e-3);
  ASSERT_TRUE(result.memory && !result.memory->covariance.empty());
  const auto expect_alike = [](const auto& law) {
    ASSERT_EQ(law.parameters.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k) {
      const double variance = *law.parameters[k].estimate.se * *law.parameters[k].estimate.se;
      EXPECT_NEAR(law.covariance[k][k], variance, 1e-6 * variance);  // rounding: both are sums of the same squares
    }
  };
  expect_alike(result.law);
  expect_alike(*result.memory);
}

TEST(FitAll, LeavesOutAndCountsWhatIsFlaggedOrNotANumber) {
  auto samples = testing::independent_samples({}, 500, 0.2, 1.4, 0.0);
  samples[3].eps = std::numeric_limits<double>::quiet_NaN();
  samples[4].v_mps = 0.0;
  samples[5].flags = {Flag::missing_impact};
  samples[6].flags = Flags::from_text("missing_impact|other");
  samples[7].flags = Flags::from_text("a_word_of_somebody_else");
  samples[8].sigma_eps = std::numeric_limits<double>::infinity();
  samples[9].sigma_v_mps = -1.0;
  samples[10].v_mps = 1e300;
  samples[11].eps = 1e6;
  const auto result = fit_all(samples, {});
  EXPECT_EQ(result.n_used, 491u);
  EXPECT_EQ(result.n_left_out.at("not_finite"), 5u);
  EXPECT_EQ(result.n_left_out.at("speed_not_positive"), 1u);
  EXPECT_EQ(result.n_left_out.at("missing_impact"), 2u);
  EXPECT_EQ(result.n_left_out.at("a_word_of_somebody_else"), 1u);
}

TEST(FitAll, OutliersOfTheLawTouchNoOtherFit) {
  auto samples = testing::independent_samples({}, 3000, 0.2, 1.4, 0.0);
  const auto clean = fit_all(samples, {});
  for (std::size_t k = 0; k < 6; ++k) {
    RestitutionSample wrong = samples[500 * k];
    wrong.eps = k % 2 == 0 ? -0.2 : 1.3;
    samples.insert(samples.begin() + static_cast<std::ptrdiff_t>(501 * k), wrong);
  }
  const auto result = fit_all(samples, {});
  EXPECT_EQ(result.n_left_out.at("outlier"), 6u);
  // the same 3,000 samples, searched from another start: each search ends within 2e-3 of a standard error
  const auto expect_alike = [](const Estimate& a, const Estimate& b) { EXPECT_NEAR(a.value, b.value, 5e-3 * *b.se); };
  expect_alike(result.law.nodes.at(1).eps, clean.law.nodes.at(1).eps);
  ASSERT_EQ(result.histograms.size(), clean.histograms.size());
  for (std::size_t k = 0; k < clean.histograms.size(); ++k) {
    EXPECT_EQ(result.histograms[k].n, clean.histograms[k].n);
    expect_alike(*result.histograms[k].slope_rising, *clean.histograms[k].slope_rising);
  }
}

TEST(FitAll, RefusesOptionsThatNobodyCouldType) {
  const RestitutionSamples samples = restitution_samples(synthetic_onsets(testing::SyntheticRun{}), {}).samples;
  const auto refused = [&](auto set) {
    FitConfig config;
    set(config);
    return test::refusal<InvalidArgument>([&] { fit_all(samples, config); });
  };
  using C = FitConfig;
  EXPECT_THAT(refused([](C& c) { c.law.node_speeds_mps = {0.3, -1.0}; }), StartsWith("nodes: '-1' must be"));
  EXPECT_THAT(refused([](C& c) { c.law.node_speeds_mps = {NAN}; }), StartsWith("nodes: 'nan' must be"));
  EXPECT_THAT(refused([](C& c) { c.law.orders = {0}; }), StartsWith("orders: '0' must be"));
  EXPECT_THAT(refused([](C& c) { c.n_goodness = static_cast<std::size_t>(-1); }), StartsWith("goodness_replicates: "));
  EXPECT_THAT(refused([](C& c) { c.dem_speed_mps = NAN; }), StartsWith("hand_off_speed: 'nan' must be"));
  EXPECT_THAT(refused([](C& c) { c.histograms.centres_mps = {0.0}; }), StartsWith("windows: '0' must be"));
  EXPECT_THAT(refused([](C& c) { c.histograms.width_mps = INFINITY; }), StartsWith("window_width: 'inf' must be"));
  EXPECT_THAT(refused([](C& c) { c.law.n_scatter_terms = 1000; }), StartsWith("n_scatter_terms: 1000 must be"));
  EXPECT_THROW(measure_roughness(samples, {.n_goodness = static_cast<std::size_t>(-1)}), InvalidArgument);
}

TEST(FitAll, OfNothingSaysSo) {
  for (const std::size_t n : {0u, 2u}) {
    const auto result = fit_all(testing::independent_samples({}, n, 0.2, 1.4, 0.0), {});
    EXPECT_EQ(result.curve.has_value(), n > 0);  // of two a value that balls may have, without constants
    EXPECT_FALSE(result.law.law);
    EXPECT_TRUE(result.constants.parameters.empty());
    EXPECT_EQ(result.constants.status, FitStatus::too_few_samples);
  }
}

nlohmann::json json_of(const RestitutionSamples& samples) {
  return nlohmann::json::parse(json_text(value_of(fit_all(samples, {}))));
}

TEST(FitJson, HasNullsAndNoNumbersWhereNothingIsKnown) {
  const auto j = json_of(testing::independent_samples({}, 2, 0.2, 1.4, 0.0));
  EXPECT_EQ(j.at("constants").at("status"), "too_few_samples");
  EXPECT_FALSE(j.at("constants").contains("A2"));
  EXPECT_TRUE(j.at("goodness").empty());
  EXPECT_TRUE(j.at("scatter").is_null());
  EXPECT_TRUE(j.at("histograms").empty());
}

FitConfig config_with(int n_threads) {
  FitConfig config;
  config.n_threads = n_threads;
  config.n_goodness = 9;
  return config;
}

TEST(FitThreads, OfFitAllAreNoMoreThanItMayStart) {
  const auto samples = testing::independent_samples({}, 5000, 0.2, 1.4, 1e-4);
  for (const int n : {1, 3}) {
    std::ptrdiff_t n_most = 0;  // while it reports its progress; those included that wait for work
    fit_all(samples, config_with(n), [&](double, double) {
      n_most = std::max(n_most, std::distance(std::filesystem::directory_iterator("/proc/self/task"), {}));
    });
    EXPECT_LE(n_most, n);
    EXPECT_GE(n_most, std::min(n, 2));
  }
}

TEST(FitThreads, TheResultDoesNotDependOnTheirNumber) {
  const auto samples = testing::independent_samples({}, 5000, 0.2, 1.4, 1e-4);
  const std::string one = json_text(value_of(fit_all(samples, config_with(1))));
  EXPECT_EQ(json_text(value_of(fit_all(samples, config_with(3)))), one);
  EXPECT_EQ(json_text(value_of(fit_all(samples, config_with(8)))), one);
}

}  // namespace
}  // namespace bouncelab::fit
