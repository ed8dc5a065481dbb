// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_template.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;

/// Template of twenty impacts of one mode at 2 kHz, gain times as loud, in hum of the given amplitude and weak noise.
std::optional<ImpactTemplate> template_of_mode(double hum, double gain = 1.0) {
  std::vector<float> samples(static_cast<std::size_t>(5.5 * kRate_hz));
  Random random(1, RandomStream::test, 0);
  for (std::size_t n = 0; n < samples.size(); ++n)
    samples[n] = static_cast<float>(
        gain * (1e-4 * random.normal() + hum * std::sin(2.0 * kPi * 50.0 * static_cast<double>(n) / kRate_hz)));
  std::vector<Candidate> impacts;
  for (int k = 0; k < 20; ++k) {
    const double t_s = 0.2 + 0.2431 * k + 1e-4 * random.uniform();
    test::add_modal_sound(samples, kRate_hz, t_s, 0.2 * gain, test::equal_modes({2000.0}, 3e-3, 0.05));
    impacts.push_back({t_s, 200.0, 0.4e-3, 50.0});
  }
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  WhiteSound white(sound);
  return estimate_template(white, learn_ar_models(sound, 48).noise, impacts, std::vector<bool>(impacts.size(), false));
}

TEST(RecordedSpectrum, RmsFrequencyIsThatOfTheModeThoughTheTemplateIsWhitened) {
  const auto learned = template_of_mode(0.0);
  ASSERT_TRUE(learned);
  EXPECT_NEAR(recorded_rms_frequency(*learned) * kRate_hz, 2000.0, 200.0);
}

TEST(RecordedSpectrum, RmsFrequencyLeavesOutHumThatIsLouderThanTheImpacts) {
  const auto learned = template_of_mode(0.5);
  ASSERT_TRUE(learned);
  EXPECT_NEAR(recorded_rms_frequency(*learned) * kRate_hz, 2000.0, 300.0);
}

TEST(RecordedSpectrum, RmsFrequencyDoesNotDependOnTheGain) {
  const auto one = template_of_mode(0.0), other = template_of_mode(0.0, 0.01);
  ASSERT_TRUE(one && other);
  EXPECT_NEAR(recorded_rms_frequency(*one) / recorded_rms_frequency(*other), 1.0, 1e-3);
}

}  // namespace
}  // namespace bouncelab::detection
