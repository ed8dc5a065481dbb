// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/records.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bouncelab/core/error.hpp"

namespace bouncelab::loop {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Records, KeepEveryBitOfADetection) {
  detection::Detection found;
  Onset onset{"a, \"b\".wav", 3, 7, 0.1 + 0.2, 1e-7 / 3.0, std::nullopt, 12.5, {Flag::overlap, Flag::by_hand}, 0.9};
  found.onsets = {onset, onset};
  found.onsets[1].t_s = std::nextafter(0.3, 1.0);
  found.onsets[1].sigma_t_s.reset();
  found.summary.channel_reason = "text of bytes that are no UTF-8 is not kept: \u00e9 is";
  found.summary.restitution_median = 0.97;
  found.drops = {{0.5, 12, 1e6}};
  found.wave = detection::LearnedWave{-1e-3, 1e-5, {0.1, -0.2}, {0.01, 5e-324}, 12};
  found.status = detection::DetectionStatus::ok;
  found.message = "one line";
  found.warnings = {"a", "b"};
  const detection::Detection with = detection_from_record(to_record(found, true), onset.recording);
  ASSERT_EQ(with.onsets.size(), 2u);
  EXPECT_EQ(with.onsets[0].recording, onset.recording);
  EXPECT_EQ(with.onsets[0].t_s, onset.t_s);
  EXPECT_EQ(with.onsets[0].sigma_t_s, onset.sigma_t_s);
  EXPECT_EQ(with.onsets[0].amplitude, std::nullopt);
  EXPECT_EQ(with.onsets[0].flags, onset.flags);
  EXPECT_EQ(with.onsets[1].t_s, found.onsets[1].t_s);
  EXPECT_EQ(with.onsets[1].sigma_t_s, std::nullopt);
  EXPECT_EQ(with.summary.channel_reason, found.summary.channel_reason);
  EXPECT_EQ(with.summary.restitution_median, 0.97);
  EXPECT_EQ(with.drops.at(0).odds, 1e6);
  EXPECT_EQ(with.wave->spread.at(1), 5e-324);
  EXPECT_EQ(with.status, detection::DetectionStatus::ok);
  EXPECT_EQ(with.warnings, found.warnings);
  EXPECT_FALSE(detection_from_record(to_record(found, false), "a").wave);
}

TEST(Records, KeepWhatIsNotFinite) {
  fit::Estimate estimate;
  estimate.value = std::nan("");
  estimate.se = kInfinity;
  estimate.ci95 = fit::Interval{-kInfinity, -0.0};
  estimate.interval_method = fit::IntervalMethod::covariance;
  estimate.identified = false;
  const fit::Estimate back = estimates_from_record(to_record(std::vector{estimate})).at(0);
  EXPECT_TRUE(std::isnan(back.value));
  EXPECT_EQ(back.se, kInfinity);
  EXPECT_EQ(back.ci95->lo, -kInfinity);
  EXPECT_TRUE(std::signbit(back.ci95->hi));
  EXPECT_FALSE(back.ci68);
  EXPECT_EQ(back.interval_method, fit::IntervalMethod::covariance);
  EXPECT_FALSE(back.identified);
  EXPECT_TRUE(estimates_from_record(to_record(std::vector<fit::Estimate>{})).empty());
  EXPECT_FALSE(replicate_from_record(to_record(fit::Replicate())));
  EXPECT_EQ(replicate_from_record(to_record(fit::Replicate{{0.1, 0.2}})), (std::vector{0.1, 0.2}));
}

TEST(Records, KeepASimulatedDropWithItsStates) {
  sim::DropResult drop;
  drop.impacts.rows = {{2, 0, 0.14, 1.38, 1.35, 0.978, 1.38, 0.978, -1}};
  drop.impacts.states.resize(1);
  drop.impacts.states[0].orientation = {0.5, -0.5, 0.5, -0.5};
  drop.energy.n_creating = 3;
  drop.energy.gained_impact_j.rotational_j = 1e-9;
  drop.end = sim::DropEnd::left_plate;
  const sim::DropResult back = simulated_drop_from_record(to_record(drop));
  EXPECT_EQ(back.impacts.rows.at(0).asperity, -1);
  EXPECT_EQ(back.impacts.states.at(0).orientation, drop.impacts.states[0].orientation);
  EXPECT_EQ(back.energy.n_creating, 3);
  EXPECT_EQ(back.energy.gained_impact_j.rotational_j, 1e-9);
  EXPECT_EQ(back.end, sim::DropEnd::left_plate);
}

TEST(Records, ThatAreNoneAreRefused) {
  for (const char* text : {"", "[", "{}", "[1,2]", "nothing"})
    EXPECT_THROW(detection_from_record(text, "a"), InvalidArgument) << text;
}

}  // namespace
}  // namespace bouncelab::loop
