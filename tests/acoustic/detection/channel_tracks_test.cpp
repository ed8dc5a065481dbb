// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_choice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "support/bouncing_sound.hpp"

namespace bouncelab::detection {
namespace {

/// Of so many sounds none can be told from another.
SameSource alike(std::size_t n) {
  BandEnergies one;
  one.log_power.fill(0.0F);
  one.added_share.fill(1.0F);
  return SameSource(std::vector(n, one));
}

/// A band in which there are these candidates, in silence: tracks are found from the candidates, and waveforms say
/// nothing.
BandOfChannel band_of(const std::vector<Candidate>& candidates, double rate_hz, double llr = 50.0) {
  BandOfChannel band;
  static const std::vector<float> silence(static_cast<std::size_t>(20 * 44100));
  band.sound = audio::source_in_memory(silence, rate_hz);
  band.models = audio::learn_ar_models(band.sound, 48);
  band.candidates = candidates;
  for (Candidate& c : band.candidates) c.log_likelihood_ratio = llr;
  band.same_source = alike(candidates.size());
  return band;
}

const std::vector<Candidate> kBall = test::candidates_of({});
constexpr double kFull_hz = 44100.0, kMiddle_hz = 4e3, kLow_hz = 1e3;

struct Channel {
  std::vector<BandOfChannel> bands;
  ChannelTracks found;
};
Channel channel_of(BandsOfChannel bands) {
  ChannelTracks found = find_tracks_in(bands);
  Channel channel{{}, std::move(found)};
  for (std::size_t b = 0; b < bands.size(); ++b) channel.bands.push_back(std::move(bands[b]));
  return channel;
}
Channel channel_of(std::vector<BandOfChannel> bands) { return channel_of(BandsOfChannel(std::move(bands))); }
bool is_preferred(const Channel& a, const Channel& b) {
  return is_preferred(a.bands[a.found.band], a.found, b.bands[b.found.band], b.found);
}

/// As a microphone records it.
Channel recorded(double ball, double noise_rms, std::uint64_t seed) {
  test::BouncingSound sound;
  sound.rate_hz = kFull_hz;
  sound.eps = 0.8;
  sound.eps_scatter = 0.0;
  sound.n_impacts = 9;
  sound.first_flight_s = 0.5;
  sound.amplitude = ball;
  sound.noise_rms = 0.0;
  std::vector<float> x = render(sound);
  test::add_noise(x, noise_rms, seed);
  return channel_of(BandsOfChannel(audio::source_in_memory(x, kFull_hz)));
}

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

TEST(ChannelTracks, LowerBandsAreNotSearchedWhereTheyHaveNothingToAdd) {
  const std::vector<Candidate> longer = test::candidates_of({.n_impacts = 14});
  std::vector<BandOfChannel> bands{band_of(kBall, kFull_hz), band_of(longer, kMiddle_hz)};
  EXPECT_EQ(channel_of(bands).found.band, 0u);
  bands[0].candidates.push_back(test::candidate(4.3, 100.0));  // what is no impact may hide some
  bands[0].same_source = alike(bands[0].candidates.size());
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

TEST(ChannelTracks, OfOneBallTheChannelIsPreferredInWhichItsImpactsRiseTheMore) {
  const Channel louder = channel_of({band_of(kBall, kFull_hz, 400.0)});
  const Channel fainter = channel_of({band_of(kBall, kFull_hz, 40.0)});
  EXPECT_TRUE(is_preferred(louder, fainter));
  EXPECT_FALSE(is_preferred(fainter, louder));
}

TEST(ChannelTracks, OfTwoMicrophonesTheOneIsPreferredThatHasTheBallLouderOrCleaner) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Channel near = recorded(0.5, 2e-3, seed), far = recorded(0.1, 2e-3, seed + 10);
    const Channel noisy = recorded(0.5, 2e-2, seed + 20);
    EXPECT_TRUE(is_preferred(near, far)) << seed;
    EXPECT_FALSE(is_preferred(far, near)) << seed;
    EXPECT_TRUE(is_preferred(near, noisy)) << seed;
    EXPECT_FALSE(is_preferred(noisy, near)) << seed;
  }
}

TEST(ChannelTracks, AChannelWithoutTheBallIsNeverPreferred) {
  const Channel with_ball = channel_of({band_of(kBall, kFull_hz, 10.0)});
  ASSERT_EQ(with_ball.found.tracks.size(), 1u);
  const Channel silent = channel_of({band_of({}, kFull_hz)});
  EXPECT_FALSE(is_preferred(silent, with_ball));
  EXPECT_TRUE(is_preferred(with_ball, silent));
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    // louder by far than the ball
    Random random(seed, RandomStream::test, 0);
    std::vector<Candidate> sounds;
    for (int k = 0; k < 30; ++k)
      sounds.push_back(test::candidate(random.uniform(0.0, 10.0), 1e4 * std::exp(random.normal())));
    test::sort_by_time(sounds);
    const Channel other = channel_of({band_of(sounds, kFull_hz, 1e4)});
    EXPECT_FALSE(is_preferred(other, with_ball)) << seed;
    EXPECT_TRUE(is_preferred(with_ball, other)) << seed;
  }
}

TEST(ChannelTracks, OfChannelsWithoutAnyTheFirstStays) {
  const Channel silent = channel_of({band_of({}, kFull_hz)});
  EXPECT_TRUE(silent.found.tracks.empty());
  EXPECT_EQ(silent.found.log_odds(), 0.0);
  EXPECT_FALSE(is_preferred(silent, silent));
}

}  // namespace
}  // namespace bouncelab::detection
