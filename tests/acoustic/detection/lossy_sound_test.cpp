// SPDX-License-Identifier: GPL-3.0-or-later
// What lossy codecs do to the sound of a ball, made by hand: nothing in the background, noise before attacks, high
// frequencies with phases of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/detection/detect.hpp"
#include "support/modal_sound.hpp"
#include "template/impact_template.hpp"
#include "template/subband_delay.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 48e3;

std::vector<double> bounce_times(int n) {
  std::vector<double> times;
  double t_s = 0.3, flight_s = 0.22;
  for (int k = 0; k < n; ++k) {
    times.push_back(t_s);
    t_s += flight_s;
    flight_s *= 0.965;
  }
  return times;
}

std::vector<float> noise(std::size_t n, double level, std::uint64_t seed) {
  std::vector<float> x(n);
  Random random(seed, RandomStream::test, 50);
  for (float& v : x) v = static_cast<float>(level * random.normal());
  return x;
}

/// Adds noise that begins before_s before an attack and ends with it.
void add_noise_before(std::vector<float>& x, double t_s, double before_s, double level, std::uint64_t seed) {
  const auto last = static_cast<std::size_t>(t_s * kRate_hz);
  const auto n = static_cast<std::size_t>(before_s * kRate_hz);
  const std::vector<float> burst = noise(n, level, seed);
  for (std::size_t k = 0; k < n; ++k) x[last - n + k] += burst[k];
}

TEST(LossySound, IsTimedAtTheAttackThoughNoiseBeginsMillisecondsBefore) {
  const std::vector<double> times = bounce_times(30);
  std::vector<float> x = noise(static_cast<std::size_t>(5.5 * kRate_hz), 1e-4, 1);
  Random random(2, RandomStream::test, 51);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double level = 0.5 * std::pow(0.965, static_cast<double>(k));
    test::add_modal_sound(x, kRate_hz, times[k], level, test::plate_impact());
    if (k % 3 > 0) add_noise_before(x, times[k], random.uniform(1e-3, 2.5e-3), 0.15 * level, 100 + k);
  }
  const Detection d = detect(x, kRate_hz, "noise before attacks");
  ASSERT_EQ(d.onsets.size(), times.size());
  const double offset_s = d.onsets[0].t_s - times[0];
  for (std::size_t k = 0; k < times.size(); ++k)
    EXPECT_NEAR(d.onsets[k].t_s - offset_s, times[k], 10e-6) << k << " stated " << *d.onsets[k].sigma_t_s;
}

TEST(LossySound, OfWhichARowOfImpactsSeemsEarlyByAsMuchIsTimedAtTheAttack) {
  // each of a row is where its neighbours, as wrong by as much, expect it
  const std::vector<double> times = bounce_times(30);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::vector<float> x = noise(static_cast<std::size_t>(5.5 * kRate_hz), 1e-4, seed);
    for (std::size_t k = 0; k < times.size(); ++k) {
      const double level = 0.5 * std::pow(0.965, static_cast<double>(k));
      test::add_modal_sound(x, kRate_hz, times[k], level, test::plate_impact());
      if (k % 10 > 4) add_noise_before(x, times[k], 1e-3, 0.2 * level, 100 * seed + k);
    }
    const Detection d = detect(x, kRate_hz, "a row begins early");
    ASSERT_EQ(d.onsets.size(), times.size());
    const double offset_s = d.onsets[0].t_s - times[0];
    for (std::size_t k = 0; k < times.size(); ++k) EXPECT_NEAR(d.onsets[k].t_s - offset_s, times[k], 10e-6) << k;
  }
}

TEST(LossySound, IsWarnedOfWhereSomethingElseHasDecodedIt) {
  const std::vector<double> times = bounce_times(12);
  std::vector<float> x = noise(static_cast<std::size_t>(3.0 * kRate_hz), 1e-4, 1);
  for (const double t_s : times) test::add_modal_sound(x, kRate_hz, t_s, 0.5, test::plate_impact());
  DetectionConfig config;
  const auto warned = [&](const Detection& d) {
    return std::any_of(d.notes.begin(), d.notes.end(),
                       [](const Note& note) { return note.kind == NoteKind::lossy_coding && note.subject == "AAC"; });
  };
  EXPECT_FALSE(warned(detect(x, kRate_hz, "as it is", config)));
  config.lossy_coding = "AAC";
  const Detection d = detect(x, kRate_hz, "decoded", config);
  ASSERT_EQ(d.onsets.size(), times.size());
  EXPECT_TRUE(warned(d));
  EXPECT_EQ(d.summary.lossy_coding, "AAC");
  // nothing was found whose times could be off
  const std::vector<float> quiet = noise(static_cast<std::size_t>(3.0 * kRate_hz), 1e-4, 1);
  EXPECT_FALSE(warned(detect(quiet, kRate_hz, "quiet", config)));
}

/// Noise below some 2 kHz, as a codec leaves it of a quiet background, and hardly any above.
std::vector<float> low_noise(std::size_t n, double level, std::uint64_t seed) {
  std::vector<float> x = noise(n, level, seed);
  for (int stage = 0; stage < 4; ++stage) {
    float last = 0.0F;
    for (float& v : x) v = last += 0.25F * (v - last);
  }
  const std::vector<float> rest = noise(n, 1e-7, seed + 1);
  for (std::size_t k = 0; k < n; ++k) x[k] += rest[k];
  return x;
}

/// Adds what a codec may make of a high band at an attack: one function of its transform, where its block begins.
void add_block_function(std::vector<float>& x, double t_s, double level) {
  constexpr std::size_t kBlock = 128;
  const std::size_t first = static_cast<std::size_t>(t_s * kRate_hz) / kBlock * kBlock;
  for (std::size_t n = 0; n < 2 * kBlock; ++n) {
    const double window = std::sin(kPi * (static_cast<double>(n) + 0.5) / (2.0 * kBlock));
    x[first + n] +=
        static_cast<float>(level * window * std::cos(2.0 * kPi * 17.3e3 / kRate_hz * static_cast<double>(n)));
  }
}

TEST(LossySound, IsNotTimedByTheCodecsBlocksWhereTheBackgroundIsEmpty) {
  const std::vector<double> times = bounce_times(30);
  std::vector<float> x = low_noise(static_cast<std::size_t>(5.5 * kRate_hz), 1e-3, 3);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double level = 0.5 * std::pow(0.965, static_cast<double>(k));
    test::add_modal_sound(x, kRate_hz, times[k], level, test::plate_impact());
    add_block_function(x, times[k], 0.05 * level);
  }
  const Detection d = detect(x, kRate_hz, "blocks");
  ASSERT_EQ(d.onsets.size(), times.size());
  const double offset_s = d.onsets[0].t_s - times[0];
  for (std::size_t k = 0; k < times.size(); ++k)
    EXPECT_NEAR(d.onsets[k].t_s - offset_s, times[k], 12e-6) << k;  // 5 us are the contact time assumed
}

/// Energy of a template above a frequency, over all of it.
double share_above(const ImpactTemplate& learned, double f_hz) {
  const std::size_t n = learned.filter.spectrum().size();
  const auto bin = static_cast<std::size_t>(f_hz / kRate_hz * static_cast<double>(learned.filter.n_window()));
  return learned.filter.energy(bin, n) / learned.filter.energy();
}

TEST(LossySound, LeavesOutHighFrequenciesWithPhasesOfTheirOwn) {
  const std::vector<double> times = bounce_times(30);
  std::vector<float> x = noise(static_cast<std::size_t>(5.5 * kRate_hz), 1e-4, 4);
  std::vector<Candidate> impacts;
  Random random(5, RandomStream::test, 52);
  test::ModalSound low;
  low.modes = {{2100.0, 2e-3}, {3700.0, 1.5e-3}, {5600.0, 1.2e-3}, {7900.0, 1e-3}};
  for (const double t_s : times) {
    test::add_modal_sound(x, kRate_hz, t_s, 0.3, low);
    // all high modes turned by one angle, as by a codec that copies a band of frequencies upwards
    const double phase_rad = random.uniform(0.0, 2.0 * kPi);
    test::ModalSound high;
    for (const double f_hz : {15.5e3, 16.3e3, 17.2e3, 18.1e3, 18.8e3})
      high.modes.push_back({f_hz, 2e-3, 1.0, phase_rad});
    test::add_modal_sound(x, kRate_hz, t_s, 0.1, high);
    impacts.push_back({t_s, 300.0, 0.4e-3, 50.0});
  }
  const audio::AudioSource sound = audio::source_in_memory(x, kRate_hz);
  const std::vector<bool> clipped(impacts.size(), false);
  WhiteSound white(sound);
  const auto learned = estimate_template(white, learn_ar_models(sound, 48).noise, impacts, clipped);
  ASSERT_TRUE(learned);
  EXPECT_EQ(learned->training_t_s.size(), 30U);
  EXPECT_LT(share_above(*learned, 14e3), 0.01);
}

TEST(LossySound, NoiseIsPredictedAlikeInEveryRecordingThoughACodecLeftNothingAboveItsLimit) {
  // Opus: white noise up to 20 kHz, 85 dB less above. The innovations have the variance that the model promises; with a
  // filter of rounding it was a millionth of that in one recording of five.
  std::vector<float> above_20_khz;  // a Hann-windowed sinc, the high-pass that leaves what is to be taken off
  constexpr int kReach = 64;
  for (int k = -kReach; k <= kReach; ++k) {
    const double cutoff = 20e3 / kRate_hz, x = 2.0 * kPi * cutoff * k;
    const double window = 0.5 + 0.5 * std::cos(kPi * k / (kReach + 1.0));
    above_20_khz.push_back(
        static_cast<float>((k == 0 ? 1.0 - 2.0 * cutoff : -2.0 * cutoff * std::sin(x) / x) * window));
  }
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const std::vector<float> white = noise(1 << 18, 1e-2, seed);
    std::vector<float> x(white.size());
    audio::correlate(white, above_20_khz, std::span(x).first(white.size() - 2 * kReach));
    for (std::size_t k = 0; k + kReach < x.size(); ++k) x[k] = white[k + kReach] - x[k];
    x.resize(white.size() - 2 * kReach);
    const audio::AudioSource sound = audio::source_in_memory(x, kRate_hz);
    const ArModel model = learn_ar_models(sound, 48).noise;
    std::vector<float> innovations(x.size() - 100);
    read_innovations(sound, model, 100, innovations);
    double sum = 0.0;
    for (const float v : innovations) sum += static_cast<double>(v) * v;
    // the quietest tenth is quieter, and the ridge of the model is no sound
    EXPECT_NEAR(model.quiet_variance / (sum / static_cast<double>(innovations.size())), 1.0, 0.25) << seed;
  }
}

TEST(ImpactWhitener, IsFiniteInDigitalSilenceAndForWindowsShorterThanTheNoisesFilter) {
  std::vector<float> x(1 << 15, 0.0F);
  test::add_modal_sound(x, 1e3, 10.0, 0.3, test::equal_modes({90.0, 210.0}, 20e-3, 0.2));
  const audio::AudioSource sound = audio::source_in_memory(x, 1e3);
  const ArModel model = learn_ar_models(sound, 48).noise;
  for (const std::vector<std::int64_t>& begins : {std::vector<std::int64_t>{9995}, std::vector<std::int64_t>{100}})
    for (const float c : impact_whitener(sound, model, begins, 32, kTemplate.unrepeated)) EXPECT_TRUE(std::isfinite(c));
}

}  // namespace
}  // namespace bouncelab::detection
