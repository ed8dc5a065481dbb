// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "contact/contact_time.hpp"
#include "support/direct_fourier.hpp"
#include "support/modal_sound.hpp"
#include "template/impact_template.hpp"
#include "template/subband_delay.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

// The kernels of the detector's timing, one by one.

constexpr std::size_t kWindow = 1024;

std::vector<float> noise(std::size_t n, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 7);
  std::vector<float> x(n);
  for (float& v : x) v = static_cast<float>(random.normal());
  return x;
}

/// Eight damped modes that start softly at sample `start`; phases[m] is added to mode m.
std::vector<float> modes(double start, const std::vector<double>& phases) {
  std::vector<float> x(kWindow, 0.0F);
  test::ModalSound sound;
  for (std::size_t m = 0; m < 8; ++m)
    sound.modes.push_back({(0.2 + 0.3 * static_cast<double>(m)) / (2.0 * kPi), 60.0, 1.0, phases[m]});
  sound.rise_s = std::sqrt(8.0);
  test::add_modal_sound(x, 1.0, start, 1.0, sound);
  return x;
}

const std::vector<double> kNoPhases(8, 0.0);

TEST(Products, CorrelateIsThePlainSumAndTheSameBytesWhereverAnOutputStands) {
  // with and without wide registers: the last of 100 outputs are computed by a whole register that overlaps the one
  // before, a span of one by none
  for (std::size_t n_taps = 1; n_taps <= 100; ++n_taps) {
    const std::size_t n = n_taps == 50 ? 2100 : 100;  // once more than are computed while they stay in the cache
    const std::vector<float> x = noise(n + n_taps, n_taps);
    const std::vector<float> taps = noise(n_taps, n_taps + 1);
    std::vector<float> out(n);
    audio::correlate(x, taps, out);
    for (std::size_t k = 0; k < out.size(); ++k) {
      float alone = 0.0F;
      audio::correlate(std::span(x).subspan(k), taps, std::span(&alone, 1));
      ASSERT_EQ(out[k], alone) << n_taps << " taps, output " << k;
      double sum = 0.0;
      for (std::size_t j = 0; j < n_taps; ++j) sum += static_cast<double>(taps[j]) * x[k + j];
      ASSERT_NEAR(out[k], sum, 2e-5);  // single precision over up to 100 terms of size 1
    }
  }
}

TEST(WhiteSound, GivesTheSameBytesAsAWindowReadAlone) {
  // windows that overlap, jump back, and reach beyond both ends, by two whiteners in turn
  const std::vector<float> x = noise(700000, 3);
  const audio::AudioSource sound = audio::source_in_memory(x, 48e3);
  const std::vector<std::vector<float>> whiteners = {noise(20, 4), noise(20, 5)};
  constexpr std::size_t kLength = 50000;
  WhiteSound white(sound);
  std::vector<float> window(kLength), alone(kLength);
  for (const std::vector<float>& whitener : {whiteners[0], whiteners[1], whiteners[0]})
    for (const std::int64_t first : {0, 100, 90, 80000, -300, -50001, 526336, 40000, 45000, 51000, 699900, 1, 2000}) {
      read_innovations(sound, {whitener, 0.0}, first, alone);
      white.read(whitener, first, window);
      EXPECT_EQ(window, alone) << first;
    }
}

TEST(RealFft, PhasorsMoveAWaveByFractionsOfASample) {
  // a packet that is band-limited and has no mean, to far below single precision
  const auto packet = [](double centre) {
    std::vector<float> x(kWindow);
    for (std::size_t n = 0; n < kWindow; ++n) {
      const double t = static_cast<double>(n) - centre;
      x[n] = static_cast<float>(std::exp(-t * t / 200.0) * std::sin(1.3 * t + 0.4));
    }
    return x;
  };
  audio::RealFft fourier(kWindow);
  const std::vector<float> moved =
      fourier.inverse(audio::phase_shifted(fourier.forward(packet(500.0)), -2.0 * kPi / kWindow * 0.37));
  const std::vector<float> direct = packet(500.37);
  double error2 = 0.0;
  for (std::size_t n = 0; n < kWindow; ++n) error2 += std::pow(moved[n] - direct[n], 2);
  EXPECT_LT(std::sqrt(error2 / audio::dot(direct, direct)), 1e-5);  // phasors to 1e-6
}

TEST(SubbandDelay, IsEstimatedAtTheCramerRaoBound) {
  audio::RealFft fourier(kWindow);
  const MatchedFilter filter(fourier.forward(modes(100.0, kNoPhases)), kWindow);
  const Subbands subbands = split_into_subbands(filter);
  const double level = 0.2;
  const double bound = level / std::sqrt(filter.information(0, filter.spectrum().size()));
  double squares = 0.0;
  double stated = 0.0;
  constexpr int kTrials = 200;
  for (int k = 0; k < kTrials; ++k) {
    std::vector<float> x = modes(100.0, kNoPhases);
    const std::vector<float> w = noise(kWindow, static_cast<std::uint64_t>(k) + 100);
    for (std::size_t n = 0; n < kWindow; ++n)
      x[n] = (x[n] + static_cast<float>(level) * w[n]) / static_cast<float>(level);
    const DelayEstimate r = estimate_delay(filter, subbands, fourier.forward(x), 0.3);
    squares += r.shift * r.shift / kTrials;
    stated += r.variance / kTrials;
  }
  // the rms of 200 trials scatters by 5 %; three of that
  EXPECT_NEAR(std::sqrt(squares) / bound, 1.0, 0.15);
  EXPECT_NEAR(std::sqrt(stated) / bound, 1.0, 0.15);
}

TEST(CorrelationPeaks, HoldEveryCycleOfAPacketTheHighestFirst) {
  // a packet of 20 samples a cycle, 3 cycles long, in noise as loud: its neighbours 20 and 40 samples off on both sides
  const auto packet = [](double centre) {
    std::vector<float> x(kWindow);
    for (std::size_t n = 0; n < kWindow; ++n) {
      const double t = static_cast<double>(n) - centre;
      x[n] = static_cast<float>(std::exp(-t * t / 1800.0) * std::sin(2.0 * kPi * t / 20.0));
    }
    return x;
  };
  audio::RealFft fourier(kWindow);
  const MatchedFilter filter(fourier.forward(packet(500.0)), kWindow);
  const std::vector<CorrelationPeak> peaks = Correlation(filter, fourier.forward(packet(506.0)), -50.0, 50.0).peaks();
  ASSERT_GE(peaks.size(), 5U);
  EXPECT_NEAR(peaks[0].shift, 6.0, 0.5);
  for (std::size_t k = 1; k < 5; ++k) {
    EXPECT_NEAR(std::abs(peaks[k].shift - 6.0), k < 3 ? 20.0 : 40.0, 1.0) << k;
    EXPECT_LE(peaks[k].log_likelihood_ratio, peaks[k - 1].log_likelihood_ratio) << k;
  }
  // energy (1 - r^2) / 2 with r = exp(-20^2 / 3600), the packet's correlation with itself a cycle later
  EXPECT_NEAR((peaks[0].log_likelihood_ratio - peaks[1].log_likelihood_ratio) / filter.energy(),
              0.5 * (1.0 - std::exp(-2.0 * 400.0 / 3600.0)), 0.01);
}

TEST(CorrelationPeaks, NearTheNyquistFrequencyStandBetweenTheSteps) {
  // 13.1 kHz at 32 kHz: half a step beside its peak a cosine is 0.8 of it, and the next cycle of this packet 0.95
  constexpr double kCycle = 2.44;  // samples
  const auto packet = [](double centre) {
    std::vector<float> x(kWindow);
    for (std::size_t n = 0; n < kWindow; ++n) {
      const double t = static_cast<double>(n) - centre;
      x[n] = static_cast<float>(std::exp(-t * t / 60.0) * std::sin(2.0 * kPi * t / kCycle));
    }
    return x;
  };
  audio::RealFft fourier(kWindow);
  const MatchedFilter filter(fourier.forward(packet(500.0)), kWindow);
  for (double delay = 5.0; delay < 6.0; delay += 0.05) {
    const CorrelationPeak peak = Correlation(filter, fourier.forward(packet(500.0 + delay)), -20.0, 20.0).highest();
    EXPECT_NEAR(peak.shift, delay, 0.05);
    EXPECT_NEAR(peak.log_likelihood_ratio, 0.5 * filter.energy(), 0.02 * filter.energy()) << delay;
  }
}

TEST(LowBand, PassesWhatIsLowWithoutDelayAndNothingElse) {
  constexpr double kRate_hz = 48e3;
  std::vector<float> x(48000);
  const auto tone = [](double f_hz, double t_s) { return std::sin(2.0 * kPi * f_hz * t_s); };
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double t_s = static_cast<double>(n) / kRate_hz;
    x[n] = static_cast<float>(tone(700.0, t_s) + tone(6100.0, t_s));
  }
  const audio::AudioSource low = decimate(audio::source_in_memory(x, kRate_hz), 12);
  EXPECT_DOUBLE_EQ(low.rate_hz, 4000.0);
  std::vector<float> y(static_cast<std::size_t>(low.n_samples));
  low.read(0, y);
  for (std::size_t n = 100; n + 100 < y.size(); ++n)
    EXPECT_NEAR(y[n], tone(700.0, static_cast<double>(n) / low.rate_hz), 0.01);  // 40 dB stop band
}

TEST(PulseSpectrum, IsTheFourierIntegralOfTheForceAndItsSlope) {
  constexpr int kSteps = 4000;
  for (int k = 1; k < 300; ++k) {
    const double x = 0.0097 * k;
    double total = 0.0, value = 0.0, slope = 0.0;
    for (int q = 0; q < kSteps; ++q) {
      const double s = (q + 0.5) / kSteps, phase = 2.0 * kPi * (s - 0.5);
      total += hertz_force(s);
      value += hertz_force(s) * std::cos(phase * x);
      slope -= hertz_force(s) * phase * std::sin(phase * x);
    }
    EXPECT_NEAR(pulse_spectrum(x).value, value / total, 2e-5) << x;  // the table is interpolated to 1e-5
    EXPECT_NEAR(pulse_spectrum(x).slope, slope / total, 1e-4)
        << x;  // and its slope to h^2 / 8 of a third derivative of 30
  }
}

constexpr double kRate_hz = 44100.0;
constexpr int kImpacts = 20;

/// Twenty impacts of one ball and, louder than all, a door: the strongest rise is not that of the ball.
TEST(ImpactTemplate, IsThatOfMostImpactsThoughTheLoudestIsOfAnotherSource) {
  std::vector<float> samples(static_cast<std::size_t>(5.5 * kRate_hz));
  Random random(3, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(1e-3 * random.normal());
  std::vector<Candidate> impacts;
  for (int k = 0; k <= kImpacts; ++k) {
    const bool is_door = k == 4;
    const double t_s = 0.2 + 0.25 * k + 1e-4 * random.uniform();
    const std::vector<double> modes_hz =
        is_door ? std::vector{700.0, 1300.0, 9000.0} : std::vector{2100.0, 5300.0, 7700.0};
    test::add_modal_sound(samples, kRate_hz, t_s, is_door ? 0.8 : 0.2, test::equal_modes(modes_hz, 3e-3, 0.05));
    impacts.push_back({t_s, is_door ? 800.0 : 200.0, 0.4e-3, 50.0});
  }
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  const std::vector<bool> clipped(impacts.size(), false);
  WhiteSound white(sound);
  const auto learned = estimate_template(white, learn_ar_models(sound, 48).noise, impacts, clipped);
  ASSERT_TRUE(learned);
  EXPECT_EQ(learned->training_t_s.size(), kImpacts);
  EXPECT_GT(learned->correlation, 0.9);
}

/// Template of twenty impacts of one mode at 2 kHz in hum of the given amplitude and weak noise.
std::optional<ImpactTemplate> template_of_mode(double hum) {
  std::vector<float> samples(static_cast<std::size_t>(5.5 * kRate_hz));
  Random random(1, RandomStream::test, 0);
  for (std::size_t n = 0; n < samples.size(); ++n)
    samples[n] = static_cast<float>(1e-4 * random.normal() +
                                    hum * std::sin(2.0 * kPi * 50.0 * static_cast<double>(n) / kRate_hz));
  std::vector<Candidate> impacts;
  for (int k = 0; k < 20; ++k) {
    const double t_s = 0.2 + 0.2431 * k + 1e-4 * random.uniform();
    test::add_modal_sound(samples, kRate_hz, t_s, 0.2, test::equal_modes({2000.0}, 3e-3, 0.05));
    impacts.push_back({t_s, 200.0, 0.4e-3, 50.0});
  }
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  WhiteSound white(sound);
  return estimate_template(white, learn_ar_models(sound, 48).noise, impacts, std::vector<bool>(impacts.size(), false));
}

TEST(RecordedSpectrum, RmsFrequencyIsThatOfTheModeThoughTheTemplateIsWhitenedAndHumIsLouderThanTheImpacts) {
  for (const double hum : {0.0, 0.5}) {
    const auto learned = template_of_mode(hum);
    ASSERT_TRUE(learned);
    EXPECT_NEAR(recorded_rms_frequency(*learned) * kRate_hz, 2000.0, hum > 0.0 ? 300.0 : 200.0);
  }
}

}  // namespace

}  // namespace bouncelab::detection
