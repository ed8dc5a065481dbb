// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rescoring.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace bouncelab::detection {
namespace {

/// Sounds enough for a track in every second of a recording.
std::vector<Candidate> sounds_of(double duration_s) {
  std::vector<Candidate> sounds;
  for (double t_s = 0.1; t_s < duration_s; t_s += 0.5) sounds.push_back({t_s, 100.0, 0.4e-3, 50.0});
  return sounds;
}

/// Log odds of one of n tracks alike.
double weighed(double log_odds, std::size_t n_tracks, double duration_s) {
  std::vector<Track> tracks(n_tracks);
  for (Track& track : tracks) track.log_odds = log_odds;
  weigh_by_drop_rate(sounds_of(duration_s), tracks);
  return tracks.front().log_odds;
}

TEST(DropRate, AClipOfOneDropIsWhatItSeems) { EXPECT_NEAR(weighed(2.0, 1, 3.0), 2.0, 1e-9); }

TEST(DropRate, AChanceRowInAnHourNeedsBetterReasons) {
  EXPECT_LT(weighed(3.0, 1, 3600.0), 0.0);
  // the rate is one in the hour at least: no track is asked for more than that
  EXPECT_GT(weighed(3.0, 1, 3600.0), 3.0 - std::log(900.0));
  double last = weighed(3.0, 1, 4.0);
  for (const double duration_s : {40.0, 400.0, 4000.0}) {
    const double now = weighed(3.0, 1, duration_s);
    EXPECT_LT(now, last);
    last = now;
  }
}

TEST(DropRate, ManyDropsSpeakForEachOther) {
  EXPECT_GT(weighed(3.0, 200, 3600.0), weighed(3.0, 20, 3600.0));
  EXPECT_GT(weighed(3.0, 20, 3600.0), weighed(3.0, 1, 3600.0));
  EXPECT_NEAR(weighed(3.0, 300, 3600.0), 3.0, 0.5);  // one in three windows: the largest rate
}

TEST(DropRate, WhatIsSureStaysSure) {
  EXPECT_GT(weighed(60.0, 1, 3600.0), 50.0);
  EXPECT_TRUE(std::isfinite(weighed(1e4, 1, 3600.0)));
  EXPECT_GT(weighed(1e4, 3, 3600.0), 1e3);
}

TEST(DropRate, SilenceOffersNoChance) {
  std::vector<Candidate> sounds = sounds_of(3.0);
  std::vector<Track> tracks(1);
  tracks[0].log_odds = 2.0;
  sounds.push_back({3600.0, 100.0, 0.4e-3, 50.0});
  weigh_by_drop_rate(sounds, tracks);
  EXPECT_NEAR(tracks[0].log_odds, 2.0, 1e-9);
  std::vector<Track> none;
  weigh_by_drop_rate(sounds, none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace bouncelab::detection
