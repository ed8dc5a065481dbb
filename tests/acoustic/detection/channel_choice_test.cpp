// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_choice.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "support/bouncing_sound.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
constexpr double kLength_s = 120.0;
constexpr double kDropEvery_s = 10.0;

/// Drops of a ball, one after the other.
std::vector<float> drops(double amplitude) {
  test::BouncingSound ball;
  ball.rate_hz = kRate_hz;
  ball.n_impacts = 40;
  ball.amplitude = amplitude;
  ball.noise_rms = 0.0;
  const std::vector<float> drop = render(ball);
  std::vector<float> x(static_cast<std::size_t>(kLength_s * kRate_hz), 0.0F);
  for (double begin_s = 0.0; begin_s < kLength_s; begin_s += kDropEvery_s)
    std::copy(drop.begin(), drop.end(), x.begin() + static_cast<std::ptrdiff_t>(begin_s * kRate_hz));
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
      const audio::AudioSource held = audio::source_in_memory(channels_[c], kRate_hz);
      sources_.push_back({held.rate_hz,
                          held.n_samples,
                          [this, c, held](std::int64_t first, std::span<float> out) {
                            n_read_[c] += std::ssize(out);
                            held.read(first, out);
                          },
                          {},
                          0});
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
    test::add_noise_burst(x, kRate_hz, random.uniform(0.0, kLength_s), 2.0, {2000.0, 0.02}, random);
  const Recording recording({with_noise(x, 2e-3, 1), with_noise(drops(0.1), 2e-3, 2)});
  const ChosenChannel chosen = recording.chosen();
  EXPECT_GT(n_impacts(chosen), 400U);
  EXPECT_GE(recording.share_read(0), 1.0);
  EXPECT_GE(recording.share_read(1), 1.0);
}

TEST(ChannelChoice, OfChannelsInWhichNothingRisesTheFirstIsChosen) {
  const std::vector<float> silence(static_cast<std::size_t>(kRate_hz), 0.0F);
  const ChosenChannel chosen = Recording({silence, silence, silence}).chosen();
  EXPECT_EQ(chosen.channel, 0U);
  EXPECT_EQ(n_impacts(chosen), 0U);
}

}  // namespace
}  // namespace bouncelab::detection
