// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/restitution.hpp"

#include <gtest/gtest.h>

namespace bouncelab::fit {
namespace {

RestitutionSample sample(const std::string& recording, std::int64_t drop, std::int64_t impact, double v_mps) {
  RestitutionSample s;
  s.recording = recording;
  s.drop = drop;
  s.impact = impact;
  s.v_mps = v_mps;
  s.eps = 0.8;
  return s;
}

TEST(PredictIntervals, AreTheFlightBeforeTimesTheCoefficientOfRestitutionOfThatDropOnly) {
  RestitutionSamples samples{sample("a.wav", 0, 1, 1.0), sample("a.wav", 1, 1, 1.0), sample("a.wav", 1, 2, 0.5),
                             sample("b.wav", 1, 1, 1.0)};
  samples[2].sigma_eps = 1e-3;
  const auto intervals = predict_intervals(samples, "a.wav", 1, ConstantLaw{0.9}, 10.0);
  ASSERT_EQ(intervals.size(), 2u);
  EXPECT_EQ(intervals[1].impact, 2);
  // 2 v / g = 0.1 s; products of two doubles
  EXPECT_DOUBLE_EQ(intervals[1].measured_s, 0.08);
  EXPECT_DOUBLE_EQ(*intervals[1].predicted_s, 0.09);
  EXPECT_DOUBLE_EQ(*intervals[1].sigma_s, 1e-4);
  EXPECT_FALSE(intervals[0].sigma_s);
}

TEST(PredictIntervals, PredictNothingWithoutALaw) {
  const auto intervals = predict_intervals({sample("a.wav", 0, 1, 1.0)}, "a.wav", 0, std::nullopt, 9.81);
  ASSERT_EQ(intervals.size(), 1u);
  EXPECT_FALSE(intervals[0].predicted_s);
}

}  // namespace
}  // namespace bouncelab::fit
