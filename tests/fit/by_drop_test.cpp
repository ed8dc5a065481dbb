// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/fit.hpp"
#include "calibration.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::independent_samples;
using ::testing::Not;

/// How many 95 % intervals hold the truth.
struct Held {
  double n, by_drop = 0.0, independent = 0.0;
};

Held held_by(const std::vector<Estimate>& estimates, double truth) {
  Held held{static_cast<double>(estimates.size())};
  for (const Estimate& e : estimates) {
    held.by_drop += e.ci95->lo <= truth && truth <= e.ci95->hi;
    held.independent += std::abs(e.value - truth) < 1.96 * e.se_independent.value();
  }
  return held;
}

/// Rising slope at 0.3 m/s of drops by the closed form of a rough ball, from 0.4 m/s: some 20 samples of each drop are
/// in the window, and share the velocity gained sideways.
std::vector<Estimate> slopes_of_drops(std::size_t n_drops, std::size_t n_seeds) {
  CalibrationConfig config;
  config.v_lo_mps = 0.25;
  config.v_hi_mps = 0.42;
  config.n_samples = 100 * n_drops;
  LawFit law;
  law.law = config.law;
  std::vector<Estimate> estimates;
  for (std::size_t seed = 0; seed < n_seeds; ++seed) {
    RestitutionSamples samples = calibration_samples(config, seed);
    std::erase_if(samples, [&](const auto& s) { return s.drop >= static_cast<std::int64_t>(n_drops); });
    const HistogramFit window = fit_histograms(samples, {{0.3}, 0.1}, law).at(0);
    EXPECT_EQ(window.drops.n, n_drops);
    EXPECT_EQ(window.drops.errors, ErrorBasis::by_drop);
    estimates.push_back(window.slope_rising.value());
  }
  return estimates;
}

double mean_of(const std::vector<Estimate>& estimates) {
  double sum = 0.0;
  for (const Estimate& e : estimates) sum += e.value / static_cast<double>(estimates.size());
  return sum;
}

TEST(ByDrop, IntervalsOfSlopesCoverWhereTheImpactsOfADropDependOnEachOther) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // the slopes of twelve drops are skew, which no standard error knows: .03 less, and the truth is that of many drops
  const auto n = test::repetitions<std::size_t>(16, 80);
  const auto of_sixty = slopes_of_drops(60, n);
  const double truth = mean_of(of_sixty);
  const Held sixty = held_by(of_sixty, truth), twelve = held_by(slopes_of_drops(12, n), truth);
  EXPECT_GE(sixty.by_drop, test::fewest_of(sixty.n, 0.95));
  EXPECT_GE(twelve.by_drop, test::fewest_of(twelve.n, 0.92));
  EXPECT_LT(sixty.independent + twelve.independent, 0.85 * 2.0 * static_cast<double>(n));
}

/// n_drops drops of 20 samples of constant eps, each drop shifted by its own amount, as large as the scatter.
RestitutionSamples shifted_drops(std::size_t n_drops, double shift, std::uint64_t seed) {
  testing::SyntheticRun run;
  run.law = ConstantLaw{0.95};
  run.seed = seed;
  RestitutionSamples samples = independent_samples(run, 20 * n_drops, 0.5, 1.0, 0.0);
  Random random(seed, RandomStream::test, 99);
  std::vector<double> shifts(n_drops);
  for (double& s : shifts) s = shift * random.normal();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].drop = static_cast<std::int64_t>(k / 20);
    samples[k].eps += shifts[k / 20];
  }
  return samples;
}

LawFitConfig constant() {
  LawFitConfig config;
  config.kind = LawKind::constant;
  return config;
}

TEST(ByDrop, IntervalsOfEpsCoverWhereDropsAreShifted) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  constexpr std::size_t kDrops = 12;
  std::vector<Estimate> estimates;
  for (std::uint64_t seed = 1; seed <= test::repetitions<std::uint64_t>(40, 150); ++seed)
    estimates.push_back(fit_law(shifted_drops(kDrops, 6e-4, seed), constant()).parameters.at(0).estimate);
  const Held held = held_by(estimates, 0.95);
  EXPECT_GE(held.by_drop, test::fewest_of(held.n, 0.93));  // the skewness of so few drops takes .02
  EXPECT_LT(held.independent, 0.80 * held.n);
}

TEST(ByDrop, ErrorsOfIndependentSamplesAreThoseOfTheModel) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // each error by drop is good to 1 / sqrt(2 * 60): some of three nodes, whose errors go together by a half; 3.5 of
  // these
  const auto n_seeds = test::repetitions<std::uint64_t>(6, 20);
  double ratio = 0.0, n = 0.0;
  for (std::uint64_t seed = 1; seed <= n_seeds; ++seed) {
    testing::SyntheticRun run;
    run.seed = seed;
    LawFitConfig config;
    config.intervals = IntervalMethod::covariance;
    const auto fit = fit_law(independent_samples(run, 60 * 95, 0.2, 1.4, 0.0), config);
    ASSERT_EQ(fit.drops.n, 60u);
    for (const NodeEstimate& node : fit.nodes) ratio += *node.eps.se / *node.eps.se_independent, n += 1.0;
  }
  EXPECT_NEAR(ratio / n, 1.0, 3.5 * std::sqrt(2.0 / 3.0 / 120.0 / static_cast<double>(n_seeds)));
}

FitConfig quick() {
  FitConfig config;
  config.law = constant();
  config.n_goodness = 0;
  return config;
}

TEST(ByDrop, NineDropsHaveTheErrorsOfIndependentSamples) {
  const FitResult nine = fit_all(shifted_drops(9, 0.0, 1), quick());
  EXPECT_EQ(nine.law.drops.n, 9u);
  EXPECT_EQ(nine.law.drops.errors, ErrorBasis::by_sample);
  // 30 samples a parameter are needed for errors that do not rest on the density
  RestitutionSamples few = shifted_drops(9, 0.0, 1);
  few.resize(100);
  const LawFit of_few = fit_law(few, constant());
  EXPECT_EQ(of_few.drops.errors, ErrorBasis::independent_samples);
  EXPECT_FALSE(of_few.parameters.at(0).estimate.se_independent);
  const FitResult ten = fit_all(shifted_drops(10, 0.0, 1), quick());
  EXPECT_EQ(ten.law.drops.errors, ErrorBasis::by_drop);
  EXPECT_TRUE(ten.law.parameters.at(0).estimate.se_independent);
}

TEST(ByDrop, TheSameNumberInTwoRecordingsIsTwoDrops) {
  RestitutionSamples samples = shifted_drops(10, 0.0, 1);
  for (auto& s : samples) s.drop %= 5;
  EXPECT_EQ(fit_law(samples, constant()).drops.n, 5u);
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].recording = k < 100 ? "a.wav" : "b.wav";
  const LawFit fit = fit_law(samples, constant());
  EXPECT_EQ(fit.drops.n, 10u);
  EXPECT_EQ(fit.drops.errors, ErrorBasis::by_drop);
}

TEST(ByDrop, WhereAllButAFewSamplesAreOfOneDropErrorsAreThoseOfIndependentSamples) {
  RestitutionSamples samples = shifted_drops(20, 0.0, 1);
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].drop = k < 14 ? static_cast<std::int64_t>(k) : 14;
  const FitResult result = fit_all(samples, quick());
  EXPECT_EQ(result.law.drops.n, 15u);
  EXPECT_EQ(result.law.drops.errors, ErrorBasis::independent_samples);
}

}  // namespace
}  // namespace bouncelab::fit
