// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_template.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

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
