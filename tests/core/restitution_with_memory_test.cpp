// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/restitution_with_memory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/fluctuation.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"

double bounce_in_cxx11(double v_mps, double eps, double q, double z1, double z2, double& reservoir_m2ps2);

namespace bouncelab {
namespace {

const SeriesLaw kLaw{};
double law_at(double v_mps) { return restitution(kLaw, v_mps); }

TEST(RestitutionWithMemory, DrawsFromTheLawOfTheFluctuation) {
  const double q = 2e-5, v = 0.5;
  std::uint64_t index = 0;
  for (const double w_before : {0.0, 1e-6, 1e-4, 5e-3}) {
    const Fluctuation law(q, {v, law_at(v), restitution_slope(kLaw, v), w_before});
    Random random(1, RandomStream::test, ++index);
    std::vector<double> u;
    double error = 0.0, gain = 0.0;
    const int n = 20000;
    for (int k = 0; k < n; ++k) {
      double w = w_before;
      const double z1 = random.normal(), z2 = random.normal();
      const double r = restitution_with_memory(v, law_at, q, z1, z2, w) - law_at(v);
      u.push_back(law.cdf(r));
      error += (w - law.reservoir_after(r)) / n;
      gain += std::abs(w - w_before) / n;
    }
    std::sort(u.begin(), u.end());
    double distance = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i)
      distance = std::max({distance, static_cast<double>(i + 1) / n - u[i], u[i] - static_cast<double>(i) / n});
    EXPECT_LT(distance, 1.95 / std::sqrt(n)) << w_before;  // Kolmogorov: p = 0.001, of 4 cases
    // reservoir_after is the mean over what r leaves open: (1 - eps^2) v^2 t^2 of scatter, a hundredth of the change,
    // averages out over 20,000 impacts
    EXPECT_LT(std::abs(error), 1e-3 * gain) << w_before;
  }
}

TEST(RestitutionWithMemory, LosesExactlyWhatTheContactDissipates) {
  // eps = 1 keeps v^2 + w; eps < 1 never creates energy
  Random random(1, RandomStream::test, 10);
  for (int k = 0; k < 1000; ++k) {
    const double v = 0.01 + random.uniform(), before = 0.1 * square(random.uniform());
    const double z1 = random.normal(), z2 = random.normal();
    double w = before;
    const double elastic = restitution_with_memory(
        v, [](double) { return 1.0; }, 1e-3, z1, z2, w);
    EXPECT_NEAR(square(elastic * v) + w, v * v + before, 1e-14);  // a few roundings of numbers below 1
    EXPECT_GE(w, 0.0);
    w = before;
    const double lossy = restitution_with_memory(v, law_at, 1e-3, z1, z2, w);
    EXPECT_LT(square(lossy * v) + w, v * v + before);
  }
}

TEST(RestitutionWithMemory, OfASmoothGrainIsTheLawAndOfASlowSpinningOneFinite) {
  double w = 0.0;
  EXPECT_NEAR(restitution_with_memory(0.7, law_at, 0.0, 1.0, -1.0, w), law_at(0.7), 1e-15);  // rounding
  EXPECT_EQ(w, 0.0);
  Random random(1, RandomStream::test, 11);
  for (const double v : {1e-9, 1e-3, 0.1})
    for (int k = 0; k < 1000; ++k) {  // far beyond the linear regime: v^2 << q w
      w = 100.0;
      const double z1 = random.normal(), z2 = random.normal();
      const double eps = restitution_with_memory(v, law_at, 1e-3, z1, z2, w);
      ASSERT_TRUE(std::isfinite(eps) && eps > -1.0 && std::isfinite(w) && w >= 0.0);
      ASSERT_LE(square(eps * v) + w, (v * v + 100.0) * (1.0 + 1e-14));
    }
}

TEST(RestitutionWithMemory, IsTheSameInCxx11) {
  double here = 2e-4, there = 2e-4;
  const double eps = restitution_with_memory(
      0.4, [](double) { return 0.98; }, 2e-5, 0.3, -1.2, here);
  EXPECT_EQ(bounce_in_cxx11(0.4, 0.98, 2e-5, 0.3, -1.2, there), eps);
  EXPECT_EQ(there, here);
}

}  // namespace
}  // namespace bouncelab
