// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/observations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

const SameSource kNone;

TEST(Observations, WhatALongerWindowFoundIsTimedByAPartOfIt) {
  std::vector<Candidate> candidates = test::candidates_of({});
  candidates[1].reach_s = 6e-3;
  const Observations o(candidates, test::kTiming_s, kNone);
  EXPECT_EQ(o[0].sigma_s, test::kTiming_s);
  EXPECT_NEAR(o[1].sigma_s, 0.15 * 6e-3, 1e-12);
}

TEST(Observations, KeepTimesAndLogarithmsOfAmplitudesAndTheirRiseOdds) {
  const std::vector<Candidate> candidates = test::candidates_of({});
  const Observations o(candidates, test::kTiming_s, kNone);
  ASSERT_EQ(o.size(), candidates.size());
  // 0.4 ms at two samples an error
  const std::vector<double> rise = log_rise_odds(candidates, 0.4e-3 * 2.0 / test::kTiming_s);
  for (std::size_t k = 0; k < o.size(); ++k) {
    EXPECT_EQ(o[k].t_s, candidates[k].t_s);
    EXPECT_NEAR(o[k].log_amplitude, std::log(candidates[k].amplitude), 1e-14);
    EXPECT_NEAR(o[k].log_rise_odds, rise[k], 1e-12);
  }
}

TEST(Observations, WithoutATracksOwnSoundsOnlyTheNeighboursAreOthers) {
  const std::vector<Candidate> candidates = test::candidates_of({});
  const Observations o(candidates, test::kTiming_s, kNone);
  const Observation alone = o.without(2, {0, 1, 2, 3});
  EXPECT_EQ(alone.t_s, o[2].t_s);
  EXPECT_EQ(alone.log_amplitude, o[2].log_amplitude);
  EXPECT_EQ(alone.log_rise_odds, o[2].log_rise_odds);
  EXPECT_NEAR(alone.neighbours.all, o[2].neighbours.all - 3.0F, 1e-6);  // itself is counted
  EXPECT_LT(clutter_intensity(alone.neighbours, 0.5, 0.0), clutter_intensity(o[2].neighbours, 0.5, 0.0));
}

TEST(Observations, AreOfOneSourceWhereTheyCannotBeToldApart) {
  const std::vector<Candidate> candidates = test::candidates_of({});
  const Observations o(candidates, test::kTiming_s, kNone);
  EXPECT_EQ(o.same_source(0, 5), 1.0);
  EXPECT_EQ(o.same_source_probability(0, 5), 0.5);
}

TEST(Observations, OfOtherSpectraHaveOtherSources) {
  const std::vector<Candidate> candidates = test::candidates_of({.n_impacts = 3});
  const SameSource energies({test::tilted(3), test::tilted(3), test::tilted(-3)});
  const Observations o(candidates, test::kTiming_s, energies);
  EXPECT_EQ(o.same_source(0, 1), 1.0);
  EXPECT_GT(o.same_source_probability(0, 1), 0.9);
  EXPECT_LT(o.same_source(0, 2), 0.1);
  EXPECT_EQ(o.same_source(0, 2), o.same_source(2, 0));
}

}  // namespace
}  // namespace bouncelab::detection
