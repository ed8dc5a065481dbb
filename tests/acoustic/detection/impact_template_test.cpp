// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/impact_template.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"

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
  const auto learned = estimate_template(sound, audio::learn_ar_models(sound, 48).noise, impacts, clipped);
  ASSERT_TRUE(learned);
  EXPECT_EQ(learned->n_impacts, kImpacts);
  EXPECT_GT(learned->correlation, 0.9);
}

}  // namespace
}  // namespace bouncelab::detection
