// SPDX-License-Identifier: GPL-3.0-or-later
// One drop as two bands of a sound show it.
#include "drops/drop_timer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace bouncelab::detection {
namespace {

constexpr double kLater_s = 0.4e-3;  // of the other band's times
constexpr int kImpacts = 24;

double time_of(int k) { return 0.3 + 0.2 * (1.0 - std::pow(0.95, k)) / 0.05; }

/// Impacts first ... last - 1, numbered from 0.
TimedDrop drop_of(int first, int last, double later_s, double correlation) {
  TimedDrop drop;
  drop.correlation = correlation;
  for (int k = first; k < last; ++k) {
    TimedImpact impact;
    impact.impact = k - first;
    impact.fit.t_s = time_of(k) + later_s;
    impact.fit.sigma_s = 5e-6;
    impact.fit.amplitude = 1.0;
    drop.impacts.push_back(impact);
  }
  return drop;
}

void expect_all(const TimedDrop& drop) {
  ASSERT_EQ(std::ssize(drop.impacts), kImpacts);
  for (int k = 0; k < kImpacts; ++k) {
    EXPECT_EQ(drop.impacts[k].impact, k);
    // the delay between the bands is exact here: what is left are roundings of a second
    EXPECT_NEAR(drop.impacts[k].fit.t_s, time_of(k), 1e-12);
  }
}

TEST(OtherBands, AddTheBeginningTheEndAndWhatIsMissingBetween) {
  TimedDrop drop = drop_of(2, 18, 0.0, 0.9);
  drop.impacts.erase(drop.impacts.begin() + 7, drop.impacts.begin() + 9);
  EXPECT_EQ(add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, INFINITY, drop), 10u);
  expect_all(drop);
}

TEST(OtherBands, AddNothingBeyondTheNextDrop) {
  TimedDrop drop = drop_of(0, 18, 0.0, 0.9);
  add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, time_of(20) - 1e-3, drop);
  EXPECT_LT(drop.impacts.back().fit.t_s, time_of(20) - 1e-3);
  EXPECT_GT(drop.impacts.size(), 18u);
}

TEST(OtherBands, AddNothingBetweenImpactsThatFollowEachOther) {
  TimedDrop drop = drop_of(0, kImpacts, 0.0, 0.9);
  TimedDrop other = drop_of(0, kImpacts, kLater_s, 0.9);
  TimedImpact echo = other.impacts[5];
  echo.fit.t_s += 20e-3;
  other.impacts.insert(other.impacts.begin() + 6, echo);
  for (std::size_t k = 6; k < other.impacts.size(); ++k) ++other.impacts[k].impact;
  EXPECT_EQ(add_impacts_of_other_band(other, -INFINITY, INFINITY, drop), 0u);
  // nor of another drop
  drop = drop_of(0, 12, 0.0, 0.9);
  EXPECT_EQ(add_impacts_of_other_band(drop_of(0, kImpacts, 55e-3, 0.9), -INFINITY, INFINITY, drop), 0u);
}

TEST(OtherBands, AddWhatIsInferredOnlyWhereTheirTemplateIsTheReliableOne) {
  TimedDrop other = drop_of(0, kImpacts, kLater_s, 0.9);
  for (std::size_t k = 18; k < other.impacts.size(); ++k) other.impacts[k].inferred = true;
  TimedDrop reliable = drop_of(0, 18, 0.0, 0.9);
  EXPECT_EQ(add_impacts_of_other_band(other, -INFINITY, INFINITY, reliable), 0u);
  TimedDrop unreliable = drop_of(0, 18, 0.0, 0.3);
  EXPECT_EQ(add_impacts_of_other_band(other, -INFINITY, INFINITY, unreliable), 6u);
  expect_all(unreliable);
}

TEST(OtherBands, StateTheErrorOfTheirDelay) {
  TimedDrop drop = drop_of(0, 18, 0.0, 0.9);
  for (std::size_t k = 0; k < drop.impacts.size(); ++k)
    drop.impacts[k].fit.t_s += 60e-6 * (static_cast<double>(k % 3) - 1.0);
  add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, INFINITY, drop);
  ASSERT_EQ(std::ssize(drop.impacts), kImpacts);
  // the median of nine differences of -60, 0 and 60 us has an error of a third of their scatter
  EXPECT_GT(drop.impacts.back().fit.sigma_s, 20e-6);
  EXPECT_NEAR(drop.impacts.back().fit.t_s, time_of(kImpacts - 1), 1e-12);
}

}  // namespace
}  // namespace bouncelab::detection
