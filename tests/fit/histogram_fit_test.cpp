// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/histogram_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bouncelab/core/error.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
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

double width_of(const std::vector<HistogramFit>& fits) { return fits[0].v_hi_mps - fits[0].v_lo_mps; }

TEST(HistogramFit, RecoversSlopesAndPeakFreeOfTimingNoise) {
  // noise from none to twice the scatter; in every window each estimate within 5 of its standard errors: those of
  // slopes go with the slope, and are too small where it comes out too low
  for (const double noise : {0.0, 5e-4, 1e-3}) {
    SyntheticRun run;
    const auto fits = fit_histograms(independent_samples(run, 40000, 0.2, 1.4, noise), {}, truth_of(run));
    ASSERT_EQ(fits.size(), 8u);
    for (const auto& h : fits) {
      SCOPED_TRACE(h.v_mps);
      ASSERT_EQ(h.status, FitStatus::ok);
      EXPECT_NEAR((h.peak_eps->value - restitution(run.law, h.v_mps)) / *h.peak_eps->se, 0.0, 5.0);
      EXPECT_NEAR((h.slope_rising->value - 1.0 / mean_below(run, h.v_mps)) / *h.slope_rising->se, 0.0, 5.0);
      EXPECT_NEAR((h.slope_falling->value - 1.0 / mean_above(run, h.v_mps)) / *h.slope_falling->se, 0.0, 5.0);
      EXPECT_GT(h.pearson->p_value, 1e-5);
    }
  }
}

TEST(HistogramFit, RatioOfSlopesIsCoveredByItsIntervals) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  double in68 = 0.0, in95 = 0.0, n = 0.0;  // of eight windows
  for (std::uint64_t seed = 1; seed <= test::repetitions<std::uint64_t>(4, 12); ++seed) {
    SyntheticRun run;
    run.seed = seed;
    const double truth = run.below_at_1mps / run.above_at_1mps;
    for (const auto& h : fit_histograms(independent_samples(run, 6000, 0.2, 1.4, 5e-4), {}, truth_of(run))) {
      in68 += h.slope_ratio->ci68->lo <= truth && truth <= h.slope_ratio->ci68->hi;
      in95 += h.slope_ratio->ci95->lo <= truth && truth <= h.slope_ratio->ci95->hi;
      n += 1.0;
    }
  }
  EXPECT_GE(in68, test::fewest_of(n, 0.68));
  EXPECT_LE(in68, test::most_of(n, 0.68));
  EXPECT_GE(in95, test::fewest_of(n, 0.95));
}

TEST(HistogramFit, SlopesDifferWhereTheIntervalOfTheirRatioLeavesOneOut) {
  SyntheticRun run;  // above over below: 3/4, 6 standard errors in 2000 samples and more; .85, 1.5 to 4 in fewer; 1
  for (const auto& [above_over_below, n] : {std::pair{0.75, 40000u}, std::pair{0.85, 8000u}, std::pair{1.0, 40000u}}) {
    run.above_at_1mps = above_over_below * run.below_at_1mps;
    std::size_t n_differ = 0;
    for (const auto& h : fit_histograms(independent_samples(run, n, 0.2, 1.4, 0.0), {}, truth_of(run))) {
      const bool differ = slopes_differ(h).value();
      EXPECT_EQ(differ, h.slope_ratio->ci95->lo > 1.0 || h.slope_ratio->ci95->hi < 1.0);
      n_differ += differ;
    }
    EXPECT_TRUE(above_over_below != 0.85 || (n_differ > 0 && n_differ < 8)) << n_differ;
  }
}

TEST(HistogramTable, HasEveryBinOfEveryWindowWithTheDensityThatTheFitIntegratesTo) {
  const auto samples = independent_samples({}, 40000, 0.2, 1.4, 1e-4);
  const auto fits = fit_histograms(samples, {}, truth_of({}));
  const Table table = histogram_table(fits);
  const auto column = [&](const char* name) { return *table.reals(name); };
  const auto count = *table.integers("count");
  const auto v = column("v_mps"), lo = column("eps_lo"), hi = column("eps_hi"), density = column("density"),
             sigma = column("sigma_density"), fitted = column("fitted");
  std::size_t row = 0;
  for (const auto& h : fits) {
    double counted = 0.0, of_density = 0.0, of_fit = 0.0;
    for (std::size_t k = 0; k < h.bins.counts.size(); ++k, ++row) {
      EXPECT_EQ(v.at(row), h.v_mps);
      EXPECT_EQ(lo.at(row), h.bins.eps_edges[k]);
      EXPECT_EQ(hi.at(row), h.bins.eps_edges[k + 1]);
      counted += static_cast<double>(count.at(row));
      of_density += density.at(row) * (hi.at(row) - lo.at(row));
      of_fit += fitted.at(row) * (hi.at(row) - lo.at(row));
      if (count.at(row) > 0)
        EXPECT_NEAR(sigma.at(row), density.at(row) / std::sqrt(static_cast<double>(count.at(row))),
                    1e-12 * density.at(row));
    }
    EXPECT_EQ(counted + static_cast<double>(h.bins.underflow + h.bins.overflow), static_cast<double>(h.n));
    EXPECT_EQ(h.n, static_cast<std::size_t>(std::count_if(samples.begin(), samples.end(), [&](const auto& s) {
                return s.v_mps >= h.v_lo_mps && s.v_mps < h.v_hi_mps;
              })));
    EXPECT_NEAR(of_density, counted / static_cast<double>(h.n), 1e-12);
    // all but what lies outside the bins, half a per cent on either side; trapezoids lose less
    EXPECT_NEAR(of_fit, 1.0, 0.01);
  }
  EXPECT_EQ(row, table.n_rows());
}

TEST(HistogramFit, FindsTheShapeThatTheScatterHas) {
  for (const double noise : {0.0, 1e-4})
    for (const Scatter scatter : {Scatter::asymmetric_laplace, Scatter::normal}) {
      SyntheticRun run;
      run.scatter = scatter;
      HistogramConfig config;
      config.centres_mps = {0.3, 0.5};  // some 5000 and 3000 samples: enough to decide
      for (const auto& h : fit_histograms(independent_samples(run, 30000, 0.2, 1.4, noise), config, truth_of(run))) {
        SCOPED_TRACE(h.v_mps);
        const bool is_normal = scatter == Scatter::normal;
        ASSERT_TRUE(h.normal);
        EXPECT_GT((is_normal ? h.normal->pearson : h.pearson)->p_value, 1e-5);
        EXPECT_GT(is_normal ? -h.normal->delta_aic : h.normal->delta_aic, 10.0);
      }
    }
}

TEST(HistogramFit, WidthIsChosenByCounts) {
  HistogramConfig config;
  config.width_mps = 0.0;
  // log-uniform speeds: n width / (v log 7) in a window; 1000 at .6 to .7 m/s in .02 from 63,000 samples
  EXPECT_NEAR(width_of(fit_histograms(independent_samples({}, 90000, 0.2, 1.4, 0.0), config, {})), 0.02, 1e-12);
  EXPECT_NEAR(width_of(fit_histograms(independent_samples({}, 30000, 0.2, 1.4, 0.0), config, {})), 0.05, 1e-12);
  EXPECT_NEAR(width_of(fit_histograms(independent_samples({}, 500, 0.2, 1.4, 0.0), config, {})), 0.2, 1e-12);
}

TEST(HistogramFit, OfTooFewSamplesHasCountsAndNoNumbers) {
  const auto fits = fit_histograms(independent_samples({}, 60, 0.2, 1.4, 0.0), {}, {});
  for (const auto& h : fits) {
    EXPECT_EQ(h.status, FitStatus::too_few_samples);
    EXPECT_FALSE(h.peak_eps || h.slope_rising || h.pearson || h.normal);
  }
  const Table table = histogram_table(fits);
  ASSERT_GT(table.n_rows(), 0u);
  for (const double fitted : *table.reals("fitted")) EXPECT_TRUE(std::isnan(fitted));
  EXPECT_TRUE(density_picture({}).counts.empty());
}

TEST(HistogramFit, SaysWhereNoiseHidesTheSlopes) {
  SyntheticRun run;
  const auto fits = fit_histograms(independent_samples(run, 1500, 0.2, 1.4, 2e-2), {}, truth_of(run));
  for (const auto& h : fits) EXPECT_NE(h.status, FitStatus::ok) << h.v_mps << " " << h.slope_rising->value;
}

TEST(HistogramFit, RejectsBadWindows) {
  EXPECT_THROW(fit_histograms({}, {{0.5}, -0.1, 30}, {}), InvalidArgument);
  EXPECT_THROW(fit_histograms({}, {{-0.5}, 0.1, 30}, {}), InvalidArgument);
}

TEST(DensityPicture, CountsEverySample) {
  const auto samples = testing::independent_samples({}, 5000, 0.2, 1.4, 0.0);
  const auto picture = density_picture(samples);
  ASSERT_EQ(picture.counts.size(), picture.eps_edges.size() - 1);
  std::size_t n = picture.n_outside;
  for (const auto& row : picture.counts) {
    ASSERT_EQ(row.size(), picture.v_edges_mps.size() - 1);
    n = std::accumulate(row.begin(), row.end(), n);
  }
  EXPECT_EQ(n, 5000u);
  EXPECT_LE(picture.n_outside, 10u);  // the outermost 0.2 %, less the margin
}

TEST(DensityPicture, OfOneSpeedOrOneEpsHasAnArea) {
  RestitutionSamples samples(10);
  for (auto& s : samples) s.v_mps = 0.5, s.eps = 0.9;
  const auto picture = density_picture(samples);
  EXPECT_GT(picture.v_edges_mps.back(), picture.v_edges_mps.front());
  EXPECT_GT(picture.eps_edges.back(), picture.eps_edges.front());
  EXPECT_EQ(picture.n_outside, 0u);
}

}  // namespace
}  // namespace bouncelab::fit
