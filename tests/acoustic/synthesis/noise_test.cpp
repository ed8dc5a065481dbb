// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/background.hpp"

#include <Random123/philox.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
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

}  // namespace
}  // namespace bouncelab::synthesis
