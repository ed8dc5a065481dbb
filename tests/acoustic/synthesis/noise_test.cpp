// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "bouncelab/core/units.hpp"

namespace bouncelab::synthesis {
namespace {

TEST(WhiteNoise, IsStandardNormal) {
  std::vector<double> x(1 << 20, 0.0);
  WhiteNoise(7, 0).add(0, 1.0, x);
  const auto n = static_cast<double>(x.size());
  double m2 = 0.0, m4 = 0.0, mean = 0.0, lag = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    mean += x[k] / n;
    m2 += x[k] * x[k] / n;
    m4 += std::pow(x[k], 4) / n;
    if (k) lag += x[k] * x[k - 1] / n;
  }
  // four standard errors: 1, sqrt 2, sqrt 96, 1 over sqrt n
  EXPECT_NEAR(mean, 0.0, 4.0 / std::sqrt(n));
  EXPECT_NEAR(m2, 1.0, 4.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m4, 3.0, 4.0 * std::sqrt(96.0 / n));
  EXPECT_NEAR(lag, 0.0, 4.0 / std::sqrt(n));
  // Kolmogorov-Smirnov over the whole range, tail and wedges included: 1.95/sqrt(n) is the 0.1% point
  std::sort(x.begin(), x.end());
  double distance = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k)
    distance =
        std::max(distance, std::abs(0.5 * std::erfc(-x[k] / std::sqrt(2.0)) - (static_cast<double>(k) + 0.5) / n));
  EXPECT_LT(distance, 1.95 / std::sqrt(n));
  // beyond 3.654, where the ziggurat draws from its tail: 271 +- 16 expected on both sides together
  const auto n_tail = std::count_if(x.begin(), x.end(), [](double v) { return std::abs(v) > 3.6541528853610088; });
  EXPECT_NEAR(static_cast<double>(n_tail), n * std::erfc(3.6541528853610088 / std::sqrt(2.0)), 4.0 * 16.5);
}

TEST(WhiteNoise, IsAFunctionOfTheFrameNumber) {
  std::vector<double> whole(1000, 0.0), part(317, 0.0);
  WhiteNoise(7, 2).add(5000, 0.5, whole);
  WhiteNoise(7, 2).add(5133, 0.5, part);
  for (std::size_t k = 0; k < part.size(); ++k) ASSERT_EQ(part[k], whole[133 + k]) << k;
  std::vector<double> other(1000, 0.0);
  WhiteNoise(7, 3).add(5000, 0.5, other);
  EXPECT_NE(other, whole);
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
