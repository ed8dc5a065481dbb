// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "channel_of_candidates.hpp"
#include "channel_tracks.hpp"
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

ChosenChannel chosen_of(const std::vector<std::vector<float>>& channels) {
  std::vector<audio::AudioSource> sources;
  for (const std::vector<float>& x : channels) sources.push_back(audio::source_in_memory(x, kFull_hz));
  return choose_channel(sources, 1, {});
}

std::size_t n_impacts(const ChosenChannel& channel) {
  std::size_t n = 0;
  for (const Track& track : channel.found.tracks) n += track.impacts.size();
  return n;
}

const std::vector<float>& ball() {
  static const std::vector<float> x = drops(0.5);
  return x;
}

TEST(ChannelChoice, OfTheSameBallTheLouderChannelIsChosenWhicheverIsTheFirst) {
  const std::vector<float> near = with_noise(ball(), 2e-3, 1), far = with_noise(drops(0.1), 2e-3, 2);
  for (const std::size_t n : {0U, 1U}) {
    const ChosenChannel chosen = chosen_of(n == 0 ? std::vector{near, far} : std::vector{far, near});
    EXPECT_EQ(chosen.channel, n);
    EXPECT_EQ(n_impacts(chosen), 12U * 40U);
  }
}

TEST(ChannelChoice, AChannelWithoutABallIsNotChosen) {
  const std::vector<float> with_ball = with_noise(ball(), 2e-3, 1);
  const std::vector<float> noise = with_noise(std::vector<float>(with_ball.size()), 0.1, 2);
  for (const std::vector<float>& other : {noise, std::vector<float>(with_ball.size(), 0.0F)})
    EXPECT_EQ(chosen_of({other, with_ball}).channel, 1U);
}

TEST(ChannelChoice, OfEqualChannelsTheFirstIsChosen) {
  const std::vector<float> x = with_noise(ball(), 2e-3, 1), silence(static_cast<std::size_t>(kFull_hz), 0.0F);
  EXPECT_EQ(chosen_of({x, x}).channel, 0U);
  const ChosenChannel silent = chosen_of({silence, silence, silence});
  EXPECT_EQ(silent.channel, 0U);
  EXPECT_EQ(n_impacts(silent), 0U);
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
