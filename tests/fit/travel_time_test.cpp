// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/restitution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

/// A ball that wanders: a new random velocity at each impact, detected through a plate.
struct Wandering {
  Onsets true_times, detected;
  TravelTime travel{2500.0, 0.1, 0.05, {}};
};
Wandering wandering_ball() {
  testing::SyntheticRun run;
  run.n_drops = 5;
  Wandering w;
  w.true_times = w.detected = synthetic_onsets(run);
  Random random(3, RandomStream::test, 0);
  double x = 0.0, y = 0.0;
  for (Onset& onset : w.detected) {
    if (onset.impact == 0) x = y = 0.0;
    x += 0.002 * random.normal();
    y += 0.002 * random.normal();
    w.travel.position_m[{onset.drop, onset.impact}] = {x, y};
    onset.t_s += std::hypot(x - 0.1, y - 0.05) / 2500.0;
  }
  return w;
}

TEST(TravelTime, CorrectionGivesBackTheTimesAtThePlate) {
  const Wandering w = wandering_ball();
  const Onsets at_plate = without_travel_time(w.detected, w.travel);
  for (std::size_t k = 0; k < at_plate.size(); ++k) EXPECT_NEAR(at_plate[k].t_s, w.true_times[k].t_s, 1e-12);
}

TEST(TravelTime, SamplesAreThoseOfTheTrueTimesAndTheCorrectionIsShown) {
  const Wandering w = wandering_ball();
  RestitutionConfig config;
  config.travel_time = w.travel;
  const auto corrected = restitution_samples(w.detected, config), truth = restitution_samples(w.true_times, {});
  ASSERT_EQ(corrected.samples.size(), truth.samples.size());
  for (std::size_t k = 0; k < truth.samples.size(); ++k)
    EXPECT_NEAR(corrected.samples[k].eps, truth.samples[k].eps, 1e-10);
  // steps of 2 mm along the line of sight are 0.8 us; sqrt(1 + (1+e)^2 ...) of them over intervals of 40 to 270 ms
  EXPECT_GT(*corrected.counts.rms_shift_travel_time, 5e-6);
  EXPECT_LT(*corrected.counts.rms_shift_travel_time, 1e-4);
}

TEST(TravelTime, AnImpactWithoutAPositionBreaksTheChainThereAndNowhereElse) {
  Wandering w = wandering_ball();
  w.travel.position_m.erase({2, 40});
  RestitutionConfig config;
  config.travel_time = w.travel;
  const auto result = restitution_samples(w.detected, config);
  EXPECT_EQ(result.counts.breaks.at(Flag::no_position), 1u);
  EXPECT_EQ(result.samples.size(), restitution_samples(w.true_times, {}).samples.size() - 3);
}

TEST(TravelTime, RejectsASpeedThatIsNone) {
  TravelTime travel;
  EXPECT_THROW(without_travel_time({}, travel), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::fit
