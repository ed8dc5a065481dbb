// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/drop_timer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/bouncing_sound.hpp"

namespace bouncelab::detection {
namespace {

test::BouncingSound ball(double amplitude) {
  test::BouncingSound b;
  b.amplitude = amplitude;
  b.n_impacts = 30;
  return b;
}

std::size_t n_clipped(const test::BouncingSound& b, const std::vector<float>& x) {
  const audio::AudioSource sound = audio::source_in_memory(x, b.rate_hz);
  const std::vector<double> impacts_s = test::impact_times(b);
  const ClippingLimits limits = find_clipping_limits(sound, impacts_s);
  return static_cast<std::size_t>(
      std::ranges::count_if(impacts_s, [&](double t_s) { return limits.are_reached(sound, t_s); }));
}

std::vector<float> limited(std::vector<float> x, float lowest, float highest) {
  for (float& value : x) value = std::clamp(value, lowest, highest);
  return x;
}

std::vector<float> rounded(std::vector<float> x, float step) {
  for (float& value : x) value = step * std::round(value / step);
  return x;
}

TEST(Clipping, IsOfTheImpactsBeyondTheLimitAndOfNoOthers) {
  const test::BouncingSound b = ball(1.0);
  const std::vector<float> whole = render(b);
  const float loudest = std::ranges::max(whole), softest = std::ranges::min(whole);
  // an amplifier's limit, below full scale and on one side alone; a converter's
  for (const bool is_above : {true, false}) {
    const float lowest = is_above ? -2.0F : 0.5F * softest, highest = is_above ? 0.5F * loudest : 2.0F;
    const auto times = test::impact_times(b);
    const auto n_beyond = static_cast<std::size_t>(std::ranges::count_if(times, [&](double t_s) {
      const auto first = whole.begin() + std::llround(t_s * b.rate_hz) - 1;
      return std::any_of(first, first + 240, [&](float value) { return value <= lowest || value >= highest; });
    }));
    ASSERT_GT(n_beyond, 2U);
    EXPECT_EQ(n_clipped(b, limited(whole, lowest, highest)), n_beyond);
  }
}

TEST(Clipping, IsNoneWhereNothingIsLimited) {
  for (const float step : {0x1p-15F, 0x1p-11F}) {
    const test::BouncingSound b = ball(0.3);
    EXPECT_EQ(n_clipped(b, rounded(render(b), step)), 0U);
  }
  // three equal samples at the crest of a slow wave, the largest of the file: at 60 Hz the crest is flat to one step of
  // 16 bit for 30 samples
  test::BouncingSound b = ball(0.0);
  std::vector<float> slow(render(b).size(), 0.0F);
  double amplitude = 0.2;
  for (const double t_s : test::impact_times(b)) {
    const auto first = static_cast<std::size_t>(std::ceil(t_s * b.rate_hz));
    for (std::size_t k = 0; k < 4800 && first + k < slow.size(); ++k) {
      const double after_s = static_cast<double>(k) / b.rate_hz;
      slow[first + k] +=
          static_cast<float>(amplitude * std::exp(-after_s / 0.05) * std::sin(2.0 * std::numbers::pi * 60.0 * after_s));
    }
    amplitude *= 0.975;
  }
  EXPECT_EQ(n_clipped(b, rounded(slow, 0x1p-15F)), 0U);
}

TEST(Clipping, OfOneImpactAloneIsNotKnown) {
  const test::BouncingSound b = ball(1.0);
  const std::vector<float> whole = render(b);
  EXPECT_EQ(n_clipped(b, limited(whole, -2.0F, 0.995F * std::ranges::max(whole))), 0U);
}

}  // namespace
}  // namespace bouncelab::detection
