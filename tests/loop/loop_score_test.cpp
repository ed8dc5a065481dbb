// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/loop_score.hpp"

#include <gtest/gtest.h>

namespace bouncelab::loop {
namespace {

fit::FitResult fit_with(double eps, double a2) {
  fit::FitResult fit;
  fit.n_used = 100;
  fit.law.nodes = {{0.6, fit::normal_estimate(eps, 1e-3)}};
  fit.law.parameters = {{"A2", fit::normal_estimate(a2, 1e-2)}};
  fit::HistogramFit window;
  window.v_mps = 0.6;
  window.slope_rising = fit::normal_estimate(500.0, 10.0);
  fit.histograms = {window};
  fit.curve.emplace().points = {{0.5, eps, {}}};
  return fit;
}

TEST(LoopScores, PutTheTruthBesideBothMeasurements) {
  const SeriesLaw truth;
  const LoopScore score = score_loop(3, {}, truth, fit_with(0.97, 0.04), fit_with(0.98, 0.05));
  EXPECT_EQ(score.n_drops, 3u);
  EXPECT_EQ(score.n_samples, 100u);
  ASSERT_EQ(score.nodes.size(), 1u);
  EXPECT_EQ(score.nodes[0].truth, restitution(truth, 0.6));
  EXPECT_EQ(score.nodes[0].eps.from_true_times->value, 0.97);
  EXPECT_EQ(score.nodes[0].eps.from_sound->value, 0.98);
  ASSERT_EQ(score.constants.size(), 3u);
  EXPECT_EQ(*score.constants[0].truth, truth.a[2]);
  EXPECT_EQ(score.constants[0].value.from_sound->value, 0.05);
  ASSERT_EQ(score.truth_curve.size(), 1u);
  EXPECT_EQ(score.truth_curve[0].eps, restitution(truth, 0.5));
}

TEST(LoopScores, PutBothLikelihoodsSideBySide) {
  fit::FitResult sound = fit_with(0.98, 0.05);
  sound.memory.emplace();
  sound.memory->nodes = {{0.6, fit::normal_estimate(0.981, 1e-4)}};
  const LoopScore score = score_loop(3, {}, SeriesLaw{}, fit_with(0.97, 0.04), sound);
  EXPECT_EQ(score.nodes[0].eps.from_sound->value, 0.98);
  EXPECT_EQ(score.nodes[0].eps_with_memory.from_sound->value, 0.981);
  EXPECT_FALSE(score.nodes[0].eps_with_memory.from_true_times);
}

TEST(LoopScores, LeaveOutWhatIsNotKnown) {
  const LoopScore score = score_loop(1, {}, ConstantLaw{0.9}, {}, fit_with(0.98, 0.05));
  EXPECT_FALSE(score.nodes[0].eps.from_true_times);
  EXPECT_FALSE(score.constants[0].truth);  // a constant law has no A2
  EXPECT_FALSE(score.constants[1].value.from_sound);
  ASSERT_EQ(score.slopes.size(), 3u);  // 0.3, 0.6, 1 m/s
  EXPECT_TRUE(score.slopes[1].rising.from_sound);
  EXPECT_FALSE(score.slopes[1].falling.from_sound);
  EXPECT_FALSE(score.slopes[0].rising.from_sound);
}

}  // namespace
}  // namespace bouncelab::loop
