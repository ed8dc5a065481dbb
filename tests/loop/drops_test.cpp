// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/drops.hpp"

#include <gtest/gtest.h>

#include <mutex>

#include "bouncelab/core/error.hpp"
#include "short_loop.hpp"

namespace bouncelab::loop {
namespace {

class Drops : public testing::Test {
 protected:
  const LoopConfig config_ = short_loop(3, 20);
  const Impacts impacts_ = sim::simulate(config_.simulation, sim::Surface{}).impacts;
  const DropRecording recording_ = drop_recording(config_.synthesis, impacts_);
};

void expect_same(const DropResult& a, const DropResult& b) {
  EXPECT_EQ(a.drop, b.drop);
  ASSERT_EQ(a.onsets.size(), b.onsets.size());
  for (std::size_t k = 0; k < a.onsets.size(); ++k) {
    EXPECT_EQ(a.onsets[k].recording, b.onsets[k].recording);
    EXPECT_EQ(a.onsets[k].t_s, b.onsets[k].t_s);
    EXPECT_EQ(a.onsets[k].sigma_t_s, b.onsets[k].sigma_t_s);
    EXPECT_EQ(a.onsets[k].snr_db, b.onsets[k].snr_db);
    EXPECT_EQ(a.onsets[k].probability, b.onsets[k].probability);
    EXPECT_EQ(a.onsets[k].flags, b.onsets[k].flags);
  }
  ASSERT_EQ(a.truth.size(), b.truth.size());
  for (std::size_t k = 0; k < a.truth.size(); ++k) {
    EXPECT_EQ(a.truth[k].t_s, b.truth[k].t_s);
    EXPECT_EQ(a.truth[k].travel_time_s, b.truth[k].travel_time_s);
    EXPECT_EQ(a.truth[k].flags, b.truth[k].flags);
  }
}

TEST_F(Drops, ComeBackFromARecordBitByBit) {
  const DropResult drop = run_drops(impacts_, "rough", recording_, {}, 1).front();
  ASSERT_FALSE(drop.onsets.empty());
  const NamedDrop back = drop_from_record(to_record("rough", drop));
  EXPECT_EQ(back.ball, "rough");
  EXPECT_EQ(back.drop.sound_s, drop.sound_s);
  expect_same(back.drop, drop);
}

TEST_F(Drops, ARecordOfAnotherFormIsRefused) {
  for (const char* record : {"", "{", "[]", "{\"ball\":\"rough\"}", "{\"ball\":1,\"drop\":\"x\"}"})
    EXPECT_THROW(drop_from_record(record), InvalidArgument) << record;
}

TEST_F(Drops, AreTheSameForAnyNumberOfThreadsAndThoseFinishedAreNotDoneAgain) {
  const std::vector<DropResult> one = run_drops(impacts_, "rough", recording_, {}, 1);
  ASSERT_EQ(one.size(), 3u);
  std::mutex mutex;
  std::vector<std::int64_t> done;
  const auto note = [&](const DropResult& drop) {
    const std::lock_guard lock(mutex);
    done.push_back(drop.drop);
  };
  const std::vector<DropResult> three = run_drops(impacts_, "rough", recording_, {one[1]}, 3, note);
  ASSERT_EQ(three.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) expect_same(one[k], three[k]);
  std::sort(done.begin(), done.end());
  EXPECT_EQ(done, (std::vector<std::int64_t>{0, 2}));
}

TEST_F(Drops, HaveOneSensor) {
  synthesis::SynthesisConfig two = config_.synthesis;
  two.channels.resize(2);
  EXPECT_THROW(drop_recording(two, impacts_), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::loop
