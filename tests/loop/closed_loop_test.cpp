// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/closed_loop.hpp"

#include <gtest/gtest.h>

#include <set>

#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/loop_score.hpp"
#include "short_loop.hpp"

namespace bouncelab::loop {
namespace {

TEST(ClosedLoop, WhatWentInComesOutWithinTheErrorsStated) {
  LoopConfig config = short_loop(4, 80);
  const LoopResult loop = run_loop(config);
  const auto& [n_true, n_marked, n_found] = loop.rough.score.agreement[kJitterTolerance];
  EXPECT_EQ(n_true, 4u * 80u);
  EXPECT_GE(n_found, 4u * 80u * 99u / 100u);
  EXPECT_LE(n_marked, n_found + 3u);
  EXPECT_TRUE(loop.smooth.recordings.empty());
  const LoopScore score =
      score_loop(loop.rough.recordings.size(), loop.rough.score, loop.simulation.law, loop.true_times, loop.sound);
  ASSERT_EQ(score.nodes.size(), 3u);
  for (const ComparedNode& node : score.nodes) {
    ASSERT_TRUE(node.eps.from_sound && node.eps.from_sound->se);
    // 4 standard errors: three nodes, one fixed seed
    EXPECT_NEAR(node.eps.from_sound->value, node.truth, 4.0 * *node.eps.from_sound->se) << node.v_mps;
  }
}

TEST(ClosedLoop, HasOneSensor) {
  LoopConfig config = short_loop(2, 10);
  config.synthesis.channels.resize(2);
  EXPECT_THROW(run_loop(config), InvalidArgument);
}

TEST(ClosedLoop, StagesReportTheirProgressAndMayBeInterrupted) {
  std::set<std::string> stages;
  run_loop(short_loop(2, 10), [&](const std::string& label, const std::string&) {
    stages.insert(label);
    return ProgressCallback{};
  });
  EXPECT_EQ(stages, (std::set<std::string>{"surface", "simulate", "synthesize and detect the rough ball", "fit"}));
  const StageProgress stop = [](const std::string& label, const std::string&) -> ProgressCallback {
    if (label == "simulate") return {};
    return [](double, double) { throw Interrupted(); };
  };
  LoopConfig config = short_loop(2, 10);
  config.surface = sim::Surface{};
  EXPECT_THROW(run_loop(config, stop), Interrupted);
}

}  // namespace
}  // namespace bouncelab::loop
