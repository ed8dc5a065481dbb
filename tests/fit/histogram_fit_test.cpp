// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/histogram_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "bouncelab/core/error.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab {
namespace {

using testing::independent_samples;
using testing::Scatter;
using testing::SyntheticRun;

LawFit truth_of(const SyntheticRun& run) {
  LawFit law;
  law.law = run.law;
  law.scatter = ScatterModel{1.0, {std::log(run.below_at_1mps), -1.0}, {std::log(run.above_at_1mps), -1.0}};
  return law;
}

TEST(HistogramFit, RecoversSlopesAndPeakFreeOfTimingNoise) {
  // noise from none to twice the scatter; in every window each estimate within 4.5 of its standard errors
  for (const double noise : {0.0, 5e-4, 1e-3}) {
    SyntheticRun run;
    const auto fits = fit_histograms(independent_samples(run, 40000, 0.2, 1.4, noise), {}, truth_of(run));
    ASSERT_EQ(fits.size(), 8u);
    for (const auto& h : fits) {
      SCOPED_TRACE(h.v_mps);
      ASSERT_EQ(h.status, FitStatus::ok) << h.message;
      EXPECT_NEAR((h.peak_eps->value - restitution(run.law, h.v_mps)) / *h.peak_eps->se, 0.0, 4.5);
      EXPECT_NEAR((h.slope_rising->value - 1.0 / mean_below(run, h.v_mps)) / *h.slope_rising->se, 0.0, 4.5);
      EXPECT_NEAR((h.slope_falling->value - 1.0 / mean_above(run, h.v_mps)) / *h.slope_falling->se, 0.0, 4.5);
      EXPECT_GT(*h.p_value, 1e-5);
    }
  }
}

TEST(HistogramFit, TellsLaplaceFromNormalBothWays) {
  SyntheticRun run;
  for (const auto& h : fit_histograms(independent_samples(run, 20000, 0.2, 1.4, 0.0), {}, truth_of(run)))
    EXPECT_GT(*h.delta_aic_gaussian, 50.0);
  run.scatter = Scatter::normal;
  for (const auto& h : fit_histograms(independent_samples(run, 20000, 0.2, 1.4, 0.0), {}, truth_of(run)))
    EXPECT_LT(*h.delta_aic_gaussian, -20.0);
}

TEST(HistogramFit, KeepsEverySampleOfTheWindow) {
  const auto samples = independent_samples({}, 5000, 0.2, 1.4, 0.0);
  for (const auto& h : fit_histograms(samples, {}, {})) {
    const auto n = std::accumulate(h.bins.counts.begin(), h.bins.counts.end(), h.bins.underflow + h.bins.overflow);
    EXPECT_EQ(n, h.n);
    const auto expected = std::count_if(samples.begin(), samples.end(),
                                        [&](const auto& s) { return s.v_mps >= h.v_lo_mps && s.v_mps < h.v_hi_mps; });
    EXPECT_EQ(h.n, static_cast<std::size_t>(expected));
  }
}

TEST(HistogramFit, CurveIntegratesToTheSharesOfTheBins) {
  const auto fits = fit_histograms(independent_samples({}, 20000, 0.2, 1.4, 3e-4), {}, {});
  for (const auto& h : fits) {
    double area = 0.0;
    for (std::size_t k = 0; k + 1 < h.curve.size(); ++k)
      area += 0.5 * (h.curve[k].y + h.curve[k + 1].y) * (h.curve[k + 1].x - h.curve[k].x);
    const double inside =
        static_cast<double>(std::accumulate(h.bins.counts.begin(), h.bins.counts.end(), std::size_t{0})) /
        static_cast<double>(h.n);
    EXPECT_NEAR(area, inside, 0.01);
  }
}

TEST(HistogramFit, OfTooFewSamplesHasCountsAndNoNumbers) {
  const auto fits = fit_histograms(independent_samples({}, 60, 0.2, 1.4, 0.0), {}, {});
  for (const auto& h : fits) {
    EXPECT_EQ(h.status, FitStatus::too_few_samples);
    EXPECT_FALSE(h.peak_eps || h.slope_rising || h.p_value);
  }
}

TEST(HistogramFit, SaysWhereNoiseHidesTheSlopes) {
  SyntheticRun run;
  const auto fits = fit_histograms(independent_samples(run, 1500, 0.2, 1.4, 2e-2), {}, truth_of(run));
  for (const auto& h : fits) EXPECT_NE(h.status, FitStatus::ok) << h.v_mps << " " << h.slope_rising->value;
}

TEST(HistogramFit, RejectsBadWindows) {
  EXPECT_THROW(fit_histograms({}, {{0.5}, 0.0, 30}, {}), InvalidArgument);
  EXPECT_THROW(fit_histograms({}, {{-0.5}, 0.1, 30}, {}), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab
