// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"
#include "candidates/candidates.hpp"
#include "channel_of_candidates.hpp"
#include "channel_tracks.hpp"
#include "support/bouncing_sound.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

// Which channel of a recording is taken, and in which band of it the tracks are found.

using test::band_of;
using test::kBall;
using test::kFull_hz;
using test::kLow_hz;
using test::kMiddle_hz;

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

SearchedChannel chosen_of(const std::vector<std::vector<float>>& channels) {
  std::vector<audio::AudioSource> sources;
  for (const std::vector<float>& x : channels) sources.push_back(audio::source_in_memory(x, kFull_hz));
  return choose_channel(sources, {}, 1, {});
}

const BandOfChannel& best_of(const SearchedChannel& channel) { return channel.bands[channel.best]; }

std::size_t n_impacts(const SearchedChannel& channel) {
  std::size_t n = 0;
  for (const Track& track : best_of(channel).tracks) n += track.impacts.size();
  return n;
}

const std::vector<float>& ball() {
  static const std::vector<float> x = drops(0.5);
  return x;
}

TEST(ChannelChoice, OfTheSameBallTheLouderOrCleanerChannelIsChosenWhicheverIsTheFirst) {
  const std::vector<float> near = with_noise(ball(), 2e-3, 1), far = with_noise(drops(0.1), 2e-3, 2);
  const std::vector<float> noisy = with_noise(ball(), 2e-2, 3);
  for (const std::vector<float>& other : {far, noisy})
    for (const std::size_t n : {0U, 1U}) {
      const SearchedChannel chosen = chosen_of(n == 0 ? std::vector{near, other} : std::vector{other, near});
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
  const SearchedChannel silent = chosen_of({silence, silence, silence});
  EXPECT_EQ(silent.channel, 0U);
  EXPECT_EQ(n_impacts(silent), 0U);
}

/// Of one band, with the tracks there.
BandOfChannel searched(const BandOfChannel& band) { return search_channel({band}).bands[0]; }

TEST(ChannelChoice, AChannelWithoutTheBallIsNeverPreferred) {
  const BandOfChannel with_ball = searched(band_of(kBall, kFull_hz, 10.0));
  ASSERT_EQ(with_ball.tracks.size(), 1u);
  const BandOfChannel silent = searched(band_of({}, kFull_hz));
  EXPECT_FALSE(is_preferred(silent, with_ball));
  EXPECT_TRUE(is_preferred(with_ball, silent));
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    // louder by far than the ball
    Random random(seed, RandomStream::test, 0);
    std::vector<Candidate> sounds;
    for (int k = 0; k < 30; ++k)
      sounds.push_back(test::candidate(random.uniform(0.0, 10.0), 1e4 * std::exp(random.normal())));
    test::sort_by_time(sounds);
    const BandOfChannel other = searched(band_of(sounds, kFull_hz, 1e4));
    EXPECT_FALSE(is_preferred(other, with_ball)) << seed;
    EXPECT_TRUE(is_preferred(with_ball, other)) << seed;
  }
}

TEST(ChannelTracks, AreThoseOfALowBandWhereOnlyThatHasTheBall) {
  const std::vector<Candidate> few(kBall.begin(), kBall.begin() + 4);
  for (std::size_t low : {1, 2}) {
    std::vector<BandOfChannel> bands{band_of(few, kFull_hz), band_of({}, kMiddle_hz), band_of({}, kLow_hz)};
    bands[0].candidates.back().log_likelihood_ratio = 12.0;  // the next are below the noise
    bands[low] = band_of(kBall, low == 1 ? kMiddle_hz : kLow_hz);
    const SearchedChannel found = search_channel(bands);
    EXPECT_EQ(found.best, low);
    ASSERT_EQ(best_of(found).tracks.size(), 1u);
    EXPECT_EQ(best_of(found).tracks[0].impacts.size(), kBall.size());
  }
}

TEST(ChannelTracks, LowerBandsAreNotSearchedWhereTheyHaveNothingToAdd) {
  const std::vector<Candidate> longer = test::candidates_of({.n_impacts = 14});
  std::vector<BandOfChannel> bands{band_of(kBall, kFull_hz), band_of(longer, kMiddle_hz)};
  EXPECT_EQ(search_channel(bands).best, 0u);
  bands[0].candidates.push_back(test::candidate(4.3, 100.0));  // what is no impact may hide some
  bands[0].same_source = test::alike(bands[0].candidates.size());
  EXPECT_EQ(search_channel(bands).best, 1u);
}

TEST(ChannelTracks, ASoftBallIsFoundInALowBandOfItsSound) {
  // thuds at 90 to 400 Hz under hiss
  std::vector<float> x(static_cast<std::size_t>(4.5 * kFull_hz));
  for (const Candidate& impact : kBall)
    test::add_modal_sound(x, kFull_hz, impact.t_s, 1e-3 * impact.amplitude,
                          test::equal_modes({90.0, 170.0, 260.0, 400.0}, 15e-3, 0.2));
  test::add_noise(x, 0.05, 1);
  const SearchedChannel channel = search_channel(bands_of(audio::source_in_memory(x, kFull_hz)));
  ASSERT_EQ(channel.bands.size(), 3u);
  EXPECT_EQ(channel.bands[0].decimation, 1);
  EXPECT_EQ(channel.bands[1].decimation, 11);
  EXPECT_EQ(channel.bands[2].decimation, 44);
  EXPECT_GT(channel.best, 0u);
  ASSERT_EQ(best_of(channel).tracks.size(), 1u);
  EXPECT_GE(best_of(channel).tracks[0].impacts.size(), 7u);
}

/// Log odds of three impacts in a lower band that are heard as these sounds; of no track nothing.
double log_odds_of_three(const std::array<test::ModalSound, 3>& sounds, std::uint64_t seed) {
  const std::vector<Candidate> impacts = test::candidates_of({.n_impacts = 3});
  std::vector<float> x(static_cast<std::size_t>(6.0 * kMiddle_hz));
  for (std::size_t k = 0; k < sounds.size(); ++k)
    test::add_modal_sound(x, kMiddle_hz, impacts[k].t_s, 1e-3 * impacts[k].amplitude, sounds[k]);
  test::add_noise(x, 0.01, seed);
  BandOfChannel band = band_of(impacts, kMiddle_hz);
  band.sound = audio::source_in_memory(x, kMiddle_hz);
  band.models = learn_ar_models(band.sound, kArOrder);
  return best_of(search_channel({band_of({}, kFull_hz), band})).log_odds();
}

TEST(ChannelTracks, ThreeImpactsThatSoundAlikeAreMoreProbableThanThreeThatDoNot) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed, RandomStream::test, 3);
    const auto any = [&] {
      return test::equal_modes(
          {random.uniform(100.0, 600.0), random.uniform(600.0, 1200.0), random.uniform(1200.0, 1900.0)},
          random.uniform(3e-3, 15e-3), 0.2);
    };
    const test::ModalSound one = any();
    EXPECT_GT(log_odds_of_three({one, one, one}, seed), log_odds_of_three({one, any(), any()}, seed) + 1.0) << seed;
  }
}

/// Noise, and sounds every 0.15 s: some at either end and where one block of the search goes over into the next.
std::vector<float> struck(double rate_hz) {
  constexpr double kSound_s = 4.0;
  std::vector<float> x(static_cast<std::size_t>(kSound_s * rate_hz));
  std::uint32_t state = 7;
  for (float& sample : x) {
    state = 1664525U * state + 1013904223U;
    sample = static_cast<float>(1e-3 * (state / 4294967296.0 - 0.5));
  }
  const test::ModalSound ping = test::equal_modes({0.1 * rate_hz, 0.23 * rate_hz}, 5e-3, 0.05);
  for (double t_s = 0.004; t_s < kSound_s; t_s += 0.15) test::add_modal_sound(x, rate_hz, t_s, 0.1, ping);
  test::add_modal_sound(x, rate_hz, kSound_s - 0.004, 0.1, ping);
  return x;
}

CandidatesOfSound found_in(const audio::AudioSource& sound, int n_threads) {
  return find_candidates(sound, learn_ar_models(sound, 48).signal, n_threads, {});
}

// hops of one sample, and just below the rates at which a hop is a sample longer: the shortest margins of a block
const double kRates_hz[] = {4000.0, 11990.0, 44100.0, 83990.0, 96000.0};

TEST(Candidates, AreInOrderTheSameOnAnyNumberOfThreadsWithTheEnergiesOfTheSoundAroundThem) {
  for (const double rate_hz : kRates_hz) {
    SCOPED_TRACE(rate_hz);
    const std::vector<float> x = struck(rate_hz);
    const audio::AudioSource sound = audio::source_in_memory(x, rate_hz);
    const CandidatesOfSound found = found_in(sound, 1), by_three = found_in(sound, 3);
    EXPECT_GE(found.candidates.size(), 27U);  // that many sounds
    ASSERT_EQ(by_three.candidates.size(), found.candidates.size());
    ASSERT_EQ(found.band_energies.size(), found.candidates.size());
    BandEnergyMeter meter(rate_hz);
    std::vector<float> around(static_cast<std::size_t>(2 * meter.reach() + 1));
    for (std::size_t k = 0; k < found.candidates.size(); ++k) {
      const Candidate &one = found.candidates[k], &other = by_three.candidates[k];
      EXPECT_EQ(one.t_s, other.t_s);
      EXPECT_EQ(one.amplitude, other.amplitude);
      EXPECT_EQ(one.log_likelihood_ratio, other.log_likelihood_ratio);
      EXPECT_TRUE(k == 0 || found.candidates[k - 1].t_s < one.t_s) << k;
      audio::read_padded(sound, std::llround(one.t_s * rate_hz) - meter.reach() - 1, around);
      for (const CandidatesOfSound* of : {&found, &by_three}) {
        EXPECT_EQ(of->band_energies[k].log_power, meter.measure(around).log_power);
        EXPECT_EQ(of->band_energies[k].added_share, meter.measure(around).added_share);
      }
    }
  }
}

}  // namespace

}  // namespace bouncelab::detection
