// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/waveform_likeness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/random.hpp"
#include "support/bouncing_sound.hpp"
#include "support/modal_sound.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
const std::vector<double> kTimes_s{0.5, 0.9, 1.22, 1.48};

double log_odds_in(const std::vector<float>& samples, const std::vector<double>& t_s) {
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  return log_odds_of_likeness(sound, learn_ar_models(sound, 48).noise, t_s);
}

/// Impacts on one plate, four fifths as loud each time.
std::vector<float> impacts(double noise_rms, double gain, std::uint64_t seed) {
  std::vector<float> samples(static_cast<std::size_t>(2.0 * kRate_hz));
  test::add_noise(samples, gain * noise_rms, seed);
  double amplitude = 0.3 * gain;
  for (const double t_s : kTimes_s)
    test::add_modal_sound(samples, kRate_hz, t_s, amplitude *= 0.8,
                          test::equal_modes({1900.0, 3100.0, 5200.0, 9400.0}, 4e-3, 0.05));
  return samples;
}

/// Bursts of noise through one resonance: spectra are alike, waveforms are not.
std::vector<float> bursts(std::uint64_t seed) {
  std::vector<float> samples(static_cast<std::size_t>(2.0 * kRate_hz));
  test::add_noise(samples, 1e-4, seed);
  Random random(seed, RandomStream::test, 2);
  for (const double t_s : kTimes_s) test::add_noise_burst(samples, kRate_hz, t_s, 0.2, {3000.0, 10e-3, 1.0}, random);
  return samples;
}

TEST(WaveformLikeness, SpeaksForImpactsOfOneBallAndAgainstSoundsOfOneSpectrum) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_GT(log_odds_in(impacts(1e-4, 1.0, seed), kTimes_s), 0.15) << seed;  // nearly the most there is
    EXPECT_LT(log_odds_in(bursts(seed), kTimes_s), -1.0) << seed;
  }
}

TEST(WaveformLikeness, DependsNeitherOnTheGainNorOnAMillisecond) {
  const double here = log_odds_in(impacts(1e-3, 1.0, 1), kTimes_s);
  EXPECT_NEAR(log_odds_in(impacts(1e-3, 1.0 / 64.0, 1), kTimes_s), here, 1e-3);
  std::vector<double> late_s = kTimes_s;
  late_s[1] += 1e-3;
  late_s[2] -= 1e-3;
  EXPECT_NEAR(log_odds_in(impacts(1e-3, 1.0, 1), late_s), here, 0.02);
}

TEST(WaveformLikeness, SaysLittleWhereNoiseIsAllThereIs) {
  const std::vector<float> samples(static_cast<std::size_t>(2.0 * kRate_hz));
  constexpr int kSeeds = 40;
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::vector<float> noise = samples;
    test::add_noise(noise, 1e-2, seed);
    const double log_odds = log_odds_in(noise, kTimes_s);
    sum += log_odds;
    EXPECT_NEAR(log_odds, 0.0, 0.8) << seed;  // mean and four times the scatter of 0.15; sounds of one spectrum have -1
  }
  // noise is learned where it is the quietest: elsewhere it is a little louder, as if something were there
  EXPECT_NEAR(sum / kSeeds, 0.0, 0.3);
  EXPECT_EQ(log_odds_in(samples, kTimes_s), 0.0);  // digital silence
}

TEST(WaveformLikeness, SaysNothingOfSoundsThatOverlap) {
  EXPECT_EQ(log_odds_in(impacts(1e-4, 1.0, 1), {0.5, 0.505, 0.51}), 0.0);
  EXPECT_EQ(log_odds_in(impacts(1e-4, 1.0, 1), {0.5}), 0.0);
}

TEST(WaveformLikeness, ReadsBeyondTheEndsOfTheSound) {
  EXPECT_TRUE(std::isfinite(log_odds_in(impacts(1e-4, 1.0, 1), {0.0, 0.5, 1.999})));
}

}  // namespace
}  // namespace bouncelab::detection
