// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_template.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"
#include "whitening/linear_prediction.hpp"

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

/// Sixteen impacts of one ball in noise, all times later and all samples louder.
std::optional<ImpactTemplate> template_of_one_ball(std::int64_t later_samples, double gain) {
  std::vector<float> samples(static_cast<std::size_t>(4.5 * kRate_hz));
  Random random(5, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(1e-3 * random.normal());
  std::vector<Candidate> impacts;
  for (int k = 0; k < 16; ++k) {
    const double t_s = 0.2 + 0.25 * k + 1e-4 * random.uniform();
    test::add_modal_sound(samples, kRate_hz, t_s, 0.2, test::equal_modes({2100.0, 5300.0, 7700.0}, 3e-3, 0.05));
    impacts.push_back({t_s + static_cast<double>(later_samples) / kRate_hz, 200.0, 0.4e-3, 50.0});
  }
  for (float& x : samples) x *= static_cast<float>(gain);
  const ArModel noise = learn_ar_models(audio::source_in_memory(samples, kRate_hz), 48).noise;
  samples.insert(samples.begin(), static_cast<std::size_t>(later_samples), 0.0F);
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  WhiteSound white(sound);
  return estimate_template(white, noise, impacts, std::vector<bool>(impacts.size(), false));
}

TEST(ImpactTemplate, MovesWithTheSoundAndDoesNotDependOnItsGain) {
  const auto one = template_of_one_ball(0, 1.0), later = template_of_one_ball(12345, 1.0),
             faint = template_of_one_ball(0, 0.01);
  ASSERT_TRUE(one && later && faint);
  ASSERT_EQ(one->training_t_s.size(), later->training_t_s.size());
  ASSERT_EQ(one->training_t_s.size(), faint->training_t_s.size());
  for (std::size_t k = 0; k < one->training_t_s.size(); ++k) {
    EXPECT_NEAR(later->training_t_s[k] - one->training_t_s[k], 12345.0 / kRate_hz, 1e-9) << k;
    EXPECT_NEAR(faint->training_t_s[k], one->training_t_s[k], 1e-8) << k;
  }
  EXPECT_NEAR(faint->peak / one->peak, 0.01, 1e-4);
  EXPECT_NEAR(faint->correlation, one->correlation, 1e-3);
}

}  // namespace
}  // namespace bouncelab::detection
