// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/detection/detect.hpp"
#include "support/modal_sound.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44.1e3;
constexpr std::size_t kImpacts = 14, kDropsOnPlate = 6;

/// Times of drops on one plate: at each place its modes are excited with other amplitudes, of either sign.
std::vector<double> drops_at_places(std::uint64_t seed, std::vector<float>& sound) {
  Random random(seed, RandomStream::test, 50);
  constexpr int kModes = 60;
  std::vector<test::Mode> modes;
  for (int m = 0; m < kModes; ++m) {
    const double f_hz = random.uniform(1e3, 18e3);
    modes.push_back({f_hz, 60.0 / (kPi * f_hz), 1.0});
  }
  std::vector<double> times_s;
  double t_s = 0.5;
  sound.assign(static_cast<std::size_t>((0.5 + kDropsOnPlate * 4.0) * kRate_hz), 0.0F);
  for (std::size_t d = 0; d < kDropsOnPlate; ++d, t_s += 1.0) {
    std::vector<double> levels;
    for (int m = 0; m < kModes; ++m) levels.push_back(random.normal());
    double flight_s = 0.25;
    for (std::size_t k = 0; k < kImpacts; ++k, t_s += flight_s) {
      times_s.push_back(t_s);
      for (std::size_t m = 0; m < modes.size(); ++m)
        test::add_modal_sound(sound, kRate_hz, t_s, flight_s * levels[m], {{modes[m]}, 9.0 * modes[m].decay_s, 0.0});
      flight_s *= 0.93 + 3e-3 * random.normal();
    }
  }
  float peak = 0.0F;
  for (const float x : sound) peak = std::max(peak, std::abs(x));
  for (float& x : sound) x = 0.5F * x / peak + 2e-3F * static_cast<float>(random.normal());
  return times_s;
}

TEST(AbsoluteTimes, OfDropsAtOtherPlacesAgreeWithinTwiceTheStandardError) {
  std::vector<double> constants_s, sigmas_s;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::vector<float> sound;
    const std::vector<double> times_s = drops_at_places(seed, sound);
    const Detection d = detect(sound, kRate_hz, "drops");
    std::map<std::int64_t, std::vector<double>> late_s;  // by drop
    for (const Onset& onset : d.onsets) {
      const auto nearest = std::min_element(times_s.begin(), times_s.end(), [&](double a, double b) {
        return std::abs(a - onset.t_s) < std::abs(b - onset.t_s);
      });
      late_s[onset.drop].push_back(onset.t_s - *nearest);
      sigmas_s.push_back(onset.sigma_t_s.value());
    }
    ASSERT_EQ(late_s.size(), kDropsOnPlate);
    std::vector<double> of_drops_s;
    for (const auto& [drop, errors_s] : late_s) of_drops_s.push_back(median(errors_s));
    const double common_s = median(of_drops_s);
    for (const double s : of_drops_s) constants_s.push_back(std::abs(s - common_s));
  }
  EXPECT_LT(median(constants_s), 2.0 * median(sigmas_s));
}

}  // namespace
}  // namespace bouncelab::detection
