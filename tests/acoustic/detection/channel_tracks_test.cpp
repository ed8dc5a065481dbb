// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_tracks.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "candidate_rows.hpp"
#include "channel_of_candidates.hpp"
#include "support/bouncing_sound.hpp"

namespace bouncelab::detection {
namespace {

using test::band_of;
using test::Channel;
using test::channel_of;
using test::kBall;
using test::kFull_hz;
using test::kLow_hz;
using test::kMiddle_hz;

TEST(ChannelTracks, AreThoseOfTheWholeBandWhereItSaysAsMuch) {
  const ChannelTracks found =
      channel_of({band_of(kBall, kFull_hz), band_of(kBall, kMiddle_hz), band_of(kBall, kLow_hz)}).found;
  EXPECT_EQ(found.band, 0u);
  ASSERT_EQ(found.tracks.size(), 1u);
  EXPECT_EQ(found.log_odds(), found.tracks[0].log_odds);
}

TEST(ChannelTracks, AreThoseOfALowBandWhereOnlyThatHasTheBall) {
  const std::vector<Candidate> few(kBall.begin(), kBall.begin() + 4);
  for (std::size_t low : {1, 2}) {
    std::vector<BandOfChannel> bands{band_of(few, kFull_hz), band_of({}, kMiddle_hz), band_of({}, kLow_hz)};
    bands[0].candidates.back().log_likelihood_ratio = 12.0;  // the next are below the noise
    bands[low] = band_of(kBall, low == 1 ? kMiddle_hz : kLow_hz);
    const ChannelTracks found = channel_of(bands).found;
    EXPECT_EQ(found.band, low);
    ASSERT_EQ(found.tracks.size(), 1u);
    EXPECT_EQ(found.tracks[0].impacts.size(), kBall.size());
  }
}

TEST(ChannelTracks, ADropThatAnotherBandShowsByItselfJoinsWithTheImpactsThatRiseHere) {
  const std::vector<Candidate> later = test::candidates_of({.first_s = 12.0});
  const std::vector<Candidate> some{later[0], later[1], later[3]};  // which are no ball's by themselves
  const auto channel = channel_of({band_of(test::joined(kBall, some), kFull_hz), band_of(later, kLow_hz)});
  EXPECT_EQ(channel.found.band, 0u);
  ASSERT_EQ(channel.found.tracks.size(), 2u);
  std::vector<std::size_t> candidates;
  std::vector<std::int64_t> numbers;
  for (const TrackImpact& impact : channel.found.tracks[1].impacts) {
    candidates.push_back(impact.candidate - kBall.size());
    numbers.push_back(impact.impact);
  }
  EXPECT_EQ(candidates, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(numbers, (std::vector<std::int64_t>{0, 1, 3}));
}

TEST(ChannelTracks, LowerBandsAreNotSearchedWhereTheyHaveNothingToAdd) {
  const std::vector<Candidate> longer = test::candidates_of({.n_impacts = 14});
  std::vector<BandOfChannel> bands{band_of(kBall, kFull_hz), band_of(longer, kMiddle_hz)};
  EXPECT_EQ(channel_of(bands).found.band, 0u);
  bands[0].candidates.push_back(test::candidate(4.3, 100.0));  // what is no impact may hide some
  bands[0].same_source = test::alike(bands[0].candidates.size());
  EXPECT_EQ(channel_of(bands).found.band, 1u);
}

TEST(ChannelTracks, ASoftBallIsFoundInALowBandOfItsSound) {
  // thuds at 90 to 400 Hz under hiss
  std::vector<float> x(static_cast<std::size_t>(4.5 * kFull_hz));
  for (const Candidate& impact : kBall)
    test::add_modal_sound(x, kFull_hz, impact.t_s, 1e-3 * impact.amplitude,
                          test::equal_modes({90.0, 170.0, 260.0, 400.0}, 15e-3, 0.2));
  test::add_noise(x, 0.05, 1);
  const Channel channel = channel_of(BandsOfChannel(audio::source_in_memory(x, kFull_hz)));
  ASSERT_EQ(channel.bands.size(), 3u);
  EXPECT_EQ(channel.bands[0].decimation, 1);
  EXPECT_EQ(channel.bands[1].decimation, 11);
  EXPECT_EQ(channel.bands[2].decimation, 44);
  EXPECT_GT(channel.found.band, 0u);
  ASSERT_EQ(channel.found.tracks.size(), 1u);
  EXPECT_GE(channel.found.tracks[0].impacts.size(), 7u);
}

}  // namespace
}  // namespace bouncelab::detection
