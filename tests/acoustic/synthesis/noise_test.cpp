// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/background.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Random123/philox.h>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "few_impacts.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"

namespace bouncelab::synthesis {
namespace {

TEST(WhiteNoise, HasTheNormalsBinsAndTails) {
  constexpr int kBins = 1200;  // of 0.01 over +-6
  constexpr std::size_t kPiece = 1 << 16;
  const int n_pieces = test::repetitions(64, 512);
  std::vector<double> counts(kBins, 0.0);
  std::vector<float> x(kPiece);
  double n_beyond_4 = 0.0, n_beyond_5 = 0.0;
  for (int piece = 0; piece < n_pieces; ++piece) {
    std::fill(x.begin(), x.end(), 0.0F);
    WhiteNoise(11, 1).add(std::int64_t{piece} * static_cast<std::int64_t>(kPiece), 1.0, std::span<float>(x));
    for (const float v : x) {
      n_beyond_4 += std::abs(v) > 4.0F ? 1.0 : 0.0;
      n_beyond_5 += std::abs(v) > 5.0F ? 1.0 : 0.0;
      if (std::abs(v) < 6.0F) counts[static_cast<std::size_t>((static_cast<double>(v) + 6.0) * 100.0)] += 1.0;
    }
  }
  const double n = static_cast<double>(kPiece) * n_pieces;
  const auto beyond = [n](double z) { return n * std::erfc(z / std::sqrt(2.0)); };
  EXPECT_NEAR(n_beyond_4, beyond(4.0), 4.0 * std::sqrt(beyond(4.0)));
  EXPECT_NEAR(n_beyond_5, beyond(5.0), 4.0 * std::sqrt(beyond(5.0)));
  double chi2 = 0.0;
  int n_bins = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const double from = static_cast<double>(k) / 100.0 - 6.0;
    const double expected = 0.5 * n * (std::erfc(from / std::sqrt(2.0)) - std::erfc((from + 0.01) / std::sqrt(2.0)));
    if (expected < 20.0) continue;
    chi2 += (counts[k] - expected) * (counts[k] - expected) / expected;
    ++n_bins;
  }
  EXPECT_GT(n_bins, 700);
  EXPECT_NEAR(chi2, n_bins, 4.0 * std::sqrt(2.0 * n_bins)) << "four standard deviations of chi squared";
}

TEST(WhiteNoise, IsWhite) {
  // coordinates of one point are 16 frames apart, points of one block 32, blocks 1; squares would show a common radius
  std::vector<double> x(test::repetitions<std::size_t>(1 << 19, 1 << 22), 0.0);
  WhiteNoise(3, 0).add(-1000, 1.0, x);
  const auto n = static_cast<double>(x.size());
  for (std::size_t lag = 1; lag <= 130; ++lag) {
    double sum = 0.0, of_squares = 0.0;
    for (std::size_t k = lag; k < x.size(); ++k) {
      sum += x[k] * x[k - lag];
      of_squares += (x[k] * x[k] - 1.0) * (x[k - lag] * x[k - lag] - 1.0);
    }
    // standard errors of 1 and 2 over sqrt n; 260 values: beyond 4.5 of them one in 600 runs, and the seed is fixed
    EXPECT_NEAR(sum * std::sqrt(1.0 / n), 0.0, 4.5) << lag;
    EXPECT_NEAR(of_squares * std::sqrt(1.0 / n), 0.0, 2.0 * 4.5) << lag;
  }
}

TEST(NoiseWords, AreThoseOfPhilox) {
  const std::uint64_t seed = 0x0123456789abcdefULL;
  for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{0xfffffff8}, std::uint64_t{0} - 16}) {
    NoiseWords words;
    words.draw(seed, 200, first);
    for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
      const std::uint64_t block = first + k;
      const auto expected =
          r123::Philox4x32{}({{static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(block >> 32), 200,
                               static_cast<std::uint32_t>(RandomStream::noise)}},
                             {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}});
      for (std::size_t w = 0; w < 4; ++w) ASSERT_EQ(words.word[w][k], expected[w]) << k << " " << w;
    }
  }
}

TEST(FlickerFilter, PowerFallsLikeOneOverFBelowTheCornerAndIsFlatAbove) {
  constexpr double kRate_hz = 48000.0, kCorner_hz = 1000.0;
  const FlickerFilter filter(kCorner_hz, kRate_hz);
  std::vector<double> response(1 << 17, 0.0);
  response[0] = 1.0;
  filter.apply(response);
  const auto power = [&](double frequency_hz) {
    std::complex<double> sum = 0.0;
    for (std::size_t k = 0; k < response.size(); ++k)
      sum += response[k] * std::polar(1.0, -2.0 * kPi * frequency_hz / kRate_hz * static_cast<double>(k));
    return std::norm(sum);
  };
  // poles and zeros an octave apart ripple by +-0.5 dB around the straight line
  EXPECT_NEAR(10.0 * std::log10(power(20.0) / power(200.0)), 10.0, 1.5);
  EXPECT_NEAR(10.0 * std::log10(power(8000.0)), 0.0, 0.5);
  double energy = 0.0;
  for (const double h : response) energy += h * h;
  EXPECT_NEAR(filter.rms(), std::sqrt(energy), 1e-4 * filter.rms());
  EXPECT_EQ(FlickerFilter(0.0, kRate_hz).rms(), 1.0);
}

// The noise of a recording, and the bound that it sets to the times.

TEST(Synthesis, NoiseIsAsLoudAsTheSnrSays) {
  SynthesisConfig config = quiet();
  config.snr_db = 20.0;
  config.lead_in_s = 3.0;
  for (const double corner_hz : {0.0, 1000.0}) {
    config.noise_corner_hz = corner_hz;
    Impacts two = impacts({0.05, 0.15});
    two.rows[1].v_mps = 0.3;
    two.rows[1].v_after_mps = 0.29;
    const SyntheticRecording recording(two, config);
    const std::vector<double> x = recording.samples();
    const double weakest = recording.truth()[1].amplitude;
    EXPECT_NEAR(recording.truth()[1].snr_db, 20.0, 1e-9);
    EXPECT_NEAR(recording.truth()[0].amplitude, config.peak, 1e-12);
    // 288,000 samples: 0.13% white; a 5 Hz floor leaves some 30 independent values of its slowest third, 10%
    EXPECT_NEAR(rms(std::span(x).first(288000)) / (0.1 * weakest), 1.0, corner_hz > 0.0 ? 0.15 : 0.006);
  }
}

TEST(Synthesis, TheBoundIsThatOfTheRenderedSoundWithEchoesAndTail) {
  for (const double level_db : {-300.0, -200.0, -60.0, -15.0, 15.0}) {  // -300: a piezo; -200: echoes alone
    SynthesisConfig config = quiet();
    config.lead_in_s = 0.02;
    config.levels = Levels{1e-4, 1e-14, 1.0};
    if (level_db >= -200.0) {
      config.sensor = microphone();
      config.sensor.reverberation.level_db = level_db;
      config.channels = {Channel{0.1, 0.1, 0.2, 1.0}};
    }
    const auto instrument = make_instrument(config);
    constexpr double kMove_samples = 0.05;  // error of the slope (omega 0.05)^2 / 6, at most 0.3 %
    const auto at = [&](double offset_samples) {
      return SyntheticRecording(impacts({0.01 + offset_samples / config.rate_hz}), config, instrument);
    };
    const std::vector<double> ahead = at(-kMove_samples).samples(), behind = at(kMove_samples).samples();
    double energy = 0.0;
    for (std::size_t k = 0; k < ahead.size(); ++k)
      energy += std::pow((ahead[k] - behind[k]) / (2.0 * kMove_samples), 2);
    const double bound_s = config.levels->noise_rms / (config.rate_hz * std::sqrt(energy));
    EXPECT_NEAR(at(0.0).truth()[0].sigma_t_s / bound_s, 1.0, 0.01) << level_db;
  }
}

/// Rms error of a matched filter that knows the wave and whitens the noise, over the bound that the truth states.
double matched_filter_error_over_bound(double corner_hz, int n_trials) {
  SynthesisConfig config = quiet();
  config.noise_corner_hz = corner_hz;
  config.lead_in_s = corner_hz > 0.0 ? 0.2 : 0.02;  // the whitening filter has to settle
  config.pause_s = 0.12;                            // what rings on is exp(-20) of the information
  config.levels = Levels{1e-4, 1e-12, 1.0};
  const auto instrument = make_instrument(config);
  const FlickerFilter noise(corner_hz, config.rate_hz);
  const auto wave_at = [&](double offset_samples) {
    return SyntheticRecording(impacts({0.01 + offset_samples / config.rate_hz}), config, instrument).samples();
  };
  // the slope from the wave moved by +-0.05 samples: error (omega 0.05)^2 / 6, at most 0.3%
  constexpr double kMove_samples = 0.05;
  const std::vector<double> ahead = wave_at(-kMove_samples), behind = wave_at(kMove_samples), wave = wave_at(0.0);
  std::vector<double> slope(wave.size());
  for (std::size_t k = 0; k < wave.size(); ++k) slope[k] = (ahead[k] - behind[k]) / (2.0 * kMove_samples);
  noise.whiten(slope);
  double energy = 0.0;
  for (const double s : slope) energy += s * s;
  config.levels->noise_rms = 0.03 * *std::max_element(wave.begin(), wave.end());
  double sum_of_squares = 0.0, bound_s = 0.0;
  for (int trial = 0; trial < n_trials; ++trial) {
    config.seed = static_cast<std::uint64_t>(trial) + 1;
    const SyntheticRecording recording(impacts({0.01}), config, instrument);
    bound_s = recording.truth()[0].sigma_t_s;
    std::vector<double> rest = recording.samples();
    for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= wave[k];
    noise.whiten(rest);
    // one Newton step from the truth: errors are hundredths of a sample, where the likelihood is a parabola
    double shift = 0.0;
    for (std::size_t k = 0; k < rest.size(); ++k) shift += rest[k] * slope[k] / energy;
    sum_of_squares += shift * shift;
  }
  return std::sqrt(sum_of_squares / n_trials) / config.rate_hz / bound_s;
}

TEST(Synthesis, AMatchedFilterThatKnowsTheWaveReachesTheBoundAlsoInFlickerNoise) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  for (const auto& [corner_hz, n_trials] :
       {std::pair{0.0, test::repetitions(200, 2000)}, std::pair{500.0, test::repetitions(40, 400)}})
    // an rms of n trials is known to 1/sqrt(2 n): three of these
    EXPECT_NEAR(matched_filter_error_over_bound(corner_hz, n_trials), 1.0, 3.0 / std::sqrt(2.0 * n_trials))
        << corner_hz;
}

}  // namespace

}  // namespace bouncelab::synthesis
