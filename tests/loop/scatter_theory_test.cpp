// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/theory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bouncelab/loop/closed_loop.hpp"
#include "short_loop.hpp"

namespace bouncelab::loop {
namespace {

constexpr std::int64_t kAsperities = 100'000;  // constant radii: s2 = 2/N = 2e-5, well inside the linear regime
const sim::RadiusLaw kRadii = sim::ConstantRadii{1e-3};

sim::SimulationConfig rough_drops(std::int64_t n_drops) {
  sim::SimulationConfig config;
  config.n_drops = n_drops;
  config.n_impacts_max = 80;
  config.n_threads = 2;
  return config;
}

std::vector<fit::HistogramFit> windows_at(const std::vector<double>& centres_mps) {
  std::vector<fit::HistogramFit> windows(centres_mps.size());
  for (std::size_t k = 0; k < windows.size(); ++k) {
    windows[k].v_mps = centres_mps[k];
    windows[k].v_lo_mps = centres_mps[k] - 0.05;
    windows[k].v_hi_mps = centres_mps[k] + 0.05;
  }
  return windows;
}

TEST(ScatterTheories, MeanDistancesAreThoseOfTheImpactsSimulated) {
  const sim::SimulationConfig config = rough_drops(150);
  const Impacts impacts = sim::simulate(config, sim::make_surface(config.ball, kAsperities, kRadii, 3)).impacts;
  const auto windows = windows_at({0.4, 0.6, 1.0});
  const auto theory =
      scatter_theory(config, contact_offset_of(config.ball, nullptr, kRadii, kAsperities), impacts, windows);
  ASSERT_TRUE(theory);
  EXPECT_NEAR(theory->q, 5.0 / 7.0 * 2.0 / kAsperities, 1e-14);  // the integral of s2 is good to 1e-9
  ASSERT_EQ(theory->slopes.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    // p(eps) is below/(below + above) exp(r/below)/below and likewise above: the mean of |r| over both sides is
    // (below^2 + above^2)/(below + above)
    double sum = 0.0;
    std::size_t n = 0;
    for (const Impact& impact : impacts.rows)
      if (impact.v_mps >= windows[k].v_lo_mps && impact.v_mps < windows[k].v_hi_mps) {
        sum += std::abs(impact.eps_macro - restitution(config.law, impact.v_mps));
        ++n;
      }
    EXPECT_EQ(theory->slopes[k].n, n);
    const double below = 1.0 / theory->slopes[k].rising, above = 1.0 / theory->slopes[k].falling;
    EXPECT_GT(below, above);
    const double expected = (below * below + above * above) / (below + above);
    // |r| of n impacts is known to 1/sqrt(n), about 3 %; impacts of a drop share their reservoir, which makes it up to
    // 1.65 times as much; two of these, and one per cent that the window's width moves the mean
    EXPECT_NEAR(sum / static_cast<double>(n), expected, (3.3 / std::sqrt(static_cast<double>(n)) + 0.01) * expected);
  }
}

TEST(ScatterTheories, DensitiesAreThoseOfTheImpactsSimulated) {
  const sim::SimulationConfig config = rough_drops(150);
  const Impacts impacts = sim::simulate(config, sim::make_surface(config.ball, kAsperities, kRadii, 3)).impacts;
  auto windows = windows_at({0.4, 0.6});
  constexpr std::size_t kBins = 12;
  for (fit::HistogramFit& window : windows) {
    const double eps = restitution(config.law, window.v_mps), half = 0.0016 / window.v_mps;  // three mean distances
    for (std::size_t k = 0; k <= kBins; ++k)
      window.bins.eps_edges.push_back(eps + half * (2.0 * static_cast<double>(k) / kBins - 1.0));
    window.bins.counts.assign(kBins, 0);
  }
  const auto theory =
      scatter_theory(config, contact_offset_of(config.ball, nullptr, kRadii, kAsperities), impacts, windows);
  ASSERT_TRUE(theory);
  ASSERT_EQ(theory->densities.size(), 2u);
  for (std::size_t w = 0; w < 2; ++w) {
    const ExpectedDensity& d = theory->densities[w];
    const std::vector<double>& edges = windows[w].bins.eps_edges;
    EXPECT_EQ(d.n_simulated, theory->slopes[w].n);
    ASSERT_EQ(d.eps.size(), d.density.size());
    // each bin by the trapezoidal rule on the points drawn, 13 a bin, the tip among them: within 1e-3
    std::vector<double> expected(kBins, 0.0);
    double sum = 0.0, in_bins = 0.0;
    for (std::size_t i = 0; i + 1 < d.eps.size(); ++i) {
      const double area = 0.5 * (d.density[i] + d.density[i + 1]) * (d.eps[i + 1] - d.eps[i]);
      const double middle = 0.5 * (d.eps[i] + d.eps[i + 1]);
      const auto bin = static_cast<std::size_t>((middle - edges.front()) / (edges.back() - edges.front()) * kBins);
      expected[std::min(bin, kBins - 1)] += area;
      sum += area;
    }
    EXPECT_LT(sum, 1.001);
    EXPECT_GT(sum, 0.8);
    double chi2 = 0.0;
    for (std::size_t k = 0; k < kBins; ++k) {
      const double n = expected[k] * static_cast<double>(d.n_simulated);
      chi2 += std::pow(static_cast<double>(d.simulated_counts[k]) - n, 2) / n;
      in_bins += static_cast<double>(d.simulated_counts[k]);
    }
    EXPECT_GT(in_bins, 0.8 * static_cast<double>(d.n_simulated));
    // 12 degrees of freedom: p = .001 at 32.9; impacts of a drop share their reservoir, which makes errors of counts up
    // to 1.65 times those of Poisson's, and a point of the curve on the edge of two bins counts for one of them
    EXPECT_LT(chi2, 1.65 * 1.65 * 32.9);
    // the peak is at eps(v)
    const auto highest = std::max_element(d.density.begin(), d.density.end()) - d.density.begin();
    EXPECT_EQ(d.eps[static_cast<std::size_t>(highest)], restitution(config.law, d.v_mps));
  }
}

TEST(ScatterTheories, SayNothingWhereTheyDoNotApply) {
  const Impacts none;
  const auto of = [&](const auto& change, double s2 = 2e-5) {
    sim::SimulationConfig config = rough_drops(1);
    change(config);
    return scatter_theory(config, {s2, 0.0}, none, {}).has_value();
  };
  EXPECT_TRUE(of([](auto&) {}));
  EXPECT_FALSE(of([](auto& c) { c.start_spin_radps = {0, 20, 0}; }));
  EXPECT_FALSE(of([](auto& c) { c.start_velocity_mps = {0.1, 0}; }));
  EXPECT_FALSE(of([](auto& c) { c.tilt_rad = 0.01; }));
  EXPECT_FALSE(of([](auto& c) { c.patch_plate = kGlass; }));
  EXPECT_FALSE(of([](auto&) {}, 0.0));  // smooth
  EXPECT_FALSE(of([](auto&) {}, 0.2));  // q = .14
}

TEST(ScatterTheories, StandBesideTheLoop) {
  const LoopConfig config = short_loop(4, 60);
  const LoopResult loop = run_loop(config);
  ASSERT_TRUE(loop.theory);
  EXPECT_EQ(loop.theory->n_transforms, 4u * 60u);
  const auto& counts = loop.theory->transform_counts;
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::size_t{0}), 4u * 60u);
  EXPECT_GT(loop.theory->q, 0.0);
}

}  // namespace
}  // namespace bouncelab::loop
