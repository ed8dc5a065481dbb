// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "bouncelab/core/random.hpp"
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

constexpr double kLength_s = 120.0;
constexpr double kDropEvery_s = 10.0;

/// Drops of a ball, one after the other.
std::vector<float> drops(double amplitude) {
  test::BouncingSound ball;
  ball.rate_hz = kFull_hz;
  ball.n_impacts = 40;
  ball.amplitude = amplitude;
  ball.noise_rms = 0.0;
  const std::vector<float> drop = render(ball);
  std::vector<float> x(static_cast<std::size_t>(kLength_s * kFull_hz), 0.0F);
  for (double begin_s = 0.0; begin_s < kLength_s; begin_s += kDropEvery_s)
    std::copy(drop.begin(), drop.end(), x.begin() + static_cast<std::ptrdiff_t>(begin_s * kFull_hz));
  return x;
}

std::vector<float> with_noise(std::vector<float> x, double rms, std::uint64_t seed) {
  test::add_noise(x, rms, seed);
  return x;
}

/// Channels from a file: what is read of each is counted.
class Recording {
 public:
  explicit Recording(std::vector<std::vector<float>> channels)
      : channels_(std::move(channels)), n_read_(channels_.size(), 0) {
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const audio::AudioSource held = audio::source_in_memory(channels_[c], kFull_hz);
      sources_.push_back({held.rate_hz, held.n_samples, [this, c, held](std::int64_t first, std::span<float> out) {
                            n_read_[c] += std::ssize(out);
                            held.read(first, out);
                          }});
    }
  }
  ChosenChannel chosen() const { return choose_channel(sources_, 1, {}); }
  /// Of a channel, over its length.
  double share_read(std::size_t channel) const {
    return static_cast<double>(n_read_[channel]) / static_cast<double>(channels_[channel].size());
  }

 private:
  std::vector<std::vector<float>> channels_;
  std::vector<std::int64_t> n_read_;
  std::vector<audio::AudioSource> sources_;
};

// 9 s for a model of the noise, 32 places and 16 impacts with 35 ms before and behind them, of two minutes
constexpr double kLook = 0.13;

std::size_t n_impacts(const ChosenChannel& channel) {
  std::size_t n = 0;
  for (const Track& track : channel.found.tracks) n += track.impacts.size();
  return n;
}

const std::vector<float>& ball() {
  static const std::vector<float> x = drops(0.5);
  return x;
}

TEST(ChannelChoice, OneLookIsTakenAtAChannelThatHasTheSameBallFainterWhicheverIsTheFirst) {
  const std::vector<float> near = with_noise(ball(), 2e-3, 1), far = with_noise(drops(0.1), 2e-3, 2);
  for (const std::size_t n : {0U, 1U}) {
    const Recording recording(n == 0 ? std::vector{near, far} : std::vector{far, near});
    const ChosenChannel chosen = recording.chosen();
    EXPECT_EQ(chosen.channel, n);
    EXPECT_EQ(n_impacts(chosen), 12U * 40U);
    EXPECT_GE(recording.share_read(n), 1.0);
    EXPECT_LT(recording.share_read(1 - n), kLook);
  }
}

TEST(ChannelChoice, OneLookIsTakenAtAChannelWithoutABall) {
  const std::vector<float> with_ball = with_noise(ball(), 2e-3, 1);
  const std::vector<float> noise = with_noise(std::vector<float>(with_ball.size()), 0.1, 2);
  for (const std::vector<float>& other : {noise, std::vector<float>(with_ball.size(), 0.0F)}) {
    const Recording recording({other, with_ball});
    EXPECT_EQ(recording.chosen().channel, 1U);
    EXPECT_LT(recording.share_read(0), kLook);
  }
}

TEST(ChannelChoice, OfTheSameSoundTwiceTheFirstIsChosen) {
  const std::vector<float> x = with_noise(ball(), 2e-3, 1);
  const Recording recording({x, x});
  EXPECT_EQ(recording.chosen().channel, 0U);
  EXPECT_LT(recording.share_read(1), kLook);
}

TEST(ChannelChoice, AllAreSearchedWhereTheBallIsNotClear) {
  // half of what rises are other sounds
  std::vector<float> x = ball();
  Random random(1, RandomStream::test, 2);
  for (int k = 0; k < 400; ++k)
    test::add_noise_burst(x, kFull_hz, random.uniform(0.0, kLength_s), 2.0, {2000.0, 0.02}, random);
  const Recording recording({with_noise(x, 2e-3, 1), with_noise(drops(0.1), 2e-3, 2)});
  const ChosenChannel chosen = recording.chosen();
  EXPECT_GT(n_impacts(chosen), 400U);
  EXPECT_GE(recording.share_read(0), 1.0);
  EXPECT_GE(recording.share_read(1), 1.0);
}

TEST(ChannelChoice, OfChannelsInWhichNothingRisesTheFirstIsChosen) {
  const std::vector<float> silence(static_cast<std::size_t>(kFull_hz), 0.0F);
  const ChosenChannel chosen = Recording({silence, silence, silence}).chosen();
  EXPECT_EQ(chosen.channel, 0U);
  EXPECT_EQ(n_impacts(chosen), 0U);
}

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

TEST(ChannelChoice, OfOneBallTheChannelIsPreferredInWhichItsImpactsRiseTheMore) {
  const Channel louder = channel_of({band_of(kBall, kFull_hz, 400.0)});
  const Channel fainter = channel_of({band_of(kBall, kFull_hz, 40.0)});
  EXPECT_TRUE(is_preferred(louder, fainter));
  EXPECT_FALSE(is_preferred(fainter, louder));
}

TEST(ChannelChoice, OfTwoMicrophonesTheOneIsPreferredThatHasTheBallLouderOrCleaner) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Channel near = recorded(0.5, 2e-3, seed), far = recorded(0.1, 2e-3, seed + 10);
    const Channel noisy = recorded(0.5, 2e-2, seed + 20);
    EXPECT_TRUE(is_preferred(near, far)) << seed;
    EXPECT_FALSE(is_preferred(far, near)) << seed;
    EXPECT_TRUE(is_preferred(near, noisy)) << seed;
    EXPECT_FALSE(is_preferred(noisy, near)) << seed;
  }
}

TEST(ChannelChoice, AChannelWithoutTheBallIsNeverPreferred) {
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

TEST(ChannelChoice, OfChannelsWithoutAnyTheFirstStays) {
  const Channel silent = channel_of({band_of({}, kFull_hz)});
  EXPECT_TRUE(silent.found.tracks.empty());
  EXPECT_EQ(silent.found.log_odds(), 0.0);
  EXPECT_FALSE(is_preferred(silent, silent));
}

}  // namespace
}  // namespace bouncelab::detection
