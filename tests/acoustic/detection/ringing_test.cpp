// SPDX-License-Identifier: GPL-3.0-or-later
// Known impacts of a sound that is nothing but them.
#include "delay/ringing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 48e3;
constexpr std::size_t kWindow = 512;

/// A decaying packet that is 0 at both ends of the window.
ImpactTemplate packet() {
  std::vector<float> x(kWindow, 0.0F);
  for (std::size_t n = 40; n < kWindow; ++n) {
    const double t = static_cast<double>(n) - 40.0;
    x[n] = static_cast<float>(t * std::exp(-t / 30.0) * std::sin(0.4 * t));
  }
  audio::RealFft fourier(kWindow);
  ImpactTemplate learned;
  learned.whitener = {1.0F};
  learned.filter = MatchedFilter(fourier.forward(x), kWindow);
  learned.n_template = kWindow;
  learned.contact_index = 40.0;
  return learned;
}

struct Impacts {
  std::vector<double> t_s, amplitude;
  std::vector<float> sound;
};

/// Impacts 1 to 4 ms apart, each ringing for 4.
Impacts close_impacts(const ImpactTemplate& learned, int n) {
  Random random(1, RandomStream::test, 0);
  Impacts impacts;
  double t_s = 0.02;
  for (int k = 0; k < n; ++k) {
    impacts.t_s.push_back(t_s += random.uniform(1e-3, 4e-3));
    impacts.amplitude.push_back(random.uniform(0.5, 2.0));
  }
  impacts.sound.resize(static_cast<std::size_t>((t_s + 0.05) * kRate_hz));
  audio::RealFft fourier(kWindow);
  for (std::size_t k = 0; k < impacts.t_s.size(); ++k) {
    const double begin = impacts.t_s[k] * kRate_hz - learned.contact_index;
    const auto first = static_cast<std::size_t>(begin);
    const std::vector<float> placed = fourier.inverse(audio::phase_shifted(
        learned.filter.spectrum(), -learned.filter.omega() * (begin - static_cast<double>(first))));
    for (std::size_t i = 0; i < kWindow; ++i)
      impacts.sound[first + i] += static_cast<float>(impacts.amplitude[k]) * placed[i];
  }
  return impacts;
}

TEST(Ringing, OfAllKnownImpactsLeavesNothingOfTheirSound) {
  const ImpactTemplate learned = packet();
  const Impacts impacts = close_impacts(learned, 12);
  const audio::AudioSource sound = audio::source_in_memory(impacts.sound, kRate_hz);
  WhiteSound white(sound);
  Ringing ringing(white, learned);
  for (std::size_t k = 0; k < impacts.t_s.size(); ++k) ringing.add(impacts.t_s[k], impacts.amplitude[k]);
  for (std::int64_t first = 0; first < 3000; first += 500) {
    const std::vector<float> x = ringing.window_without(first);
    EXPECT_LT(audio::dot(x, x), 1e-6 * learned.filter.energy()) << first;
  }
  const auto of_sixth = static_cast<std::int64_t>(impacts.t_s[6] * kRate_hz - learned.contact_index);
  const std::vector<float> alone = ringing.window_without(of_sixth, 6);
  EXPECT_NEAR(audio::dot(alone, alone) / (square(impacts.amplitude[6]) * learned.filter.energy()), 1.0, 1e-3);
}

TEST(Ringing, FitsTheAmplitudesOfOverlappingImpactsTogether) {
  const ImpactTemplate learned = packet();
  const Impacts impacts = close_impacts(learned, 40);
  const audio::AudioSource sound = audio::source_in_memory(impacts.sound, kRate_hz);
  for (const double gain : {1.0, 1e-3}) {  // of the first guess: one step, since the problem is linear
    WhiteSound white(sound);
    Ringing ringing(white, learned);
    for (const double t_s : impacts.t_s) ringing.add(t_s, gain);
    ringing.fit_amplitudes(std::vector<bool>(impacts.t_s.size(), true));
    for (std::size_t k = 0; k < impacts.t_s.size(); ++k)
      EXPECT_NEAR(ringing.amplitude(k), impacts.amplitude[k], 1e-3) << k;
  }
}

TEST(Ringing, LeavesAmplitudesThatAreGiven) {
  const ImpactTemplate learned = packet();
  const Impacts impacts = close_impacts(learned, 12);
  const audio::AudioSource sound = audio::source_in_memory(impacts.sound, kRate_hz);
  WhiteSound white(sound);
  Ringing ringing(white, learned);
  std::vector<bool> free(impacts.t_s.size(), true);
  free[5] = false;
  for (std::size_t k = 0; k < impacts.t_s.size(); ++k)
    ringing.add(impacts.t_s[k], free[k] ? 1.0 : impacts.amplitude[k]);
  ringing.fit_amplitudes(free);
  for (std::size_t k = 0; k < impacts.t_s.size(); ++k)
    EXPECT_NEAR(ringing.amplitude(k), impacts.amplitude[k], 1e-3) << k;
}

TEST(Ringing, SharesTheAmplitudeBetweenImpactsThatCannotBeToldApart) {
  const ImpactTemplate learned = packet();
  const Impacts impacts = close_impacts(learned, 1);
  const audio::AudioSource sound = audio::source_in_memory(impacts.sound, kRate_hz);
  for (const double apart_s : {0.0, 1e-10, 1e-8}) {
    WhiteSound white(sound);
    Ringing ringing(white, learned);
    ringing.add(impacts.t_s[0], 0.3);
    ringing.add(impacts.t_s[0] + apart_s, 0.3);
    ringing.fit_amplitudes({true, true});
    EXPECT_NEAR(ringing.amplitude(0) + ringing.amplitude(1), impacts.amplitude[0], 1e-2) << apart_s;
    EXPECT_NEAR(ringing.amplitude(0), ringing.amplitude(1), 0.5 * impacts.amplitude[0]) << apart_s;
  }
}

}  // namespace
}  // namespace bouncelab::detection
