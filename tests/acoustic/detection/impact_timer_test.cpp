// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/impact_timer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
constexpr int kImpacts = 20;

double time_of(int k) { return 0.2 + 0.25 * k + 1e-5 * k * k; }

/// Twenty impacts of three modes in noise.
std::vector<float> recording() {
  std::vector<float> samples(static_cast<std::size_t>(5.5 * kRate_hz));
  Random random(7, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(1e-2 * random.normal());
  for (int k = 0; k < kImpacts; ++k)
    for (auto n = static_cast<std::size_t>(std::ceil(time_of(k) * kRate_hz)); n < samples.size(); ++n) {
      const double s = static_cast<double>(n) / kRate_hz - time_of(k);
      if (s > 0.05) break;
      for (const double f_hz : {2100.0, 5300.0, 7700.0})
        samples[n] += static_cast<float>(0.2 * std::exp(-s / 3e-3) * std::sin(2.0 * kPi * f_hz * s));
    }
  return samples;
}

TEST(ImpactTimer, GivesTheSameMarginToAnImpactFoundFarFromWhereItWasExpected) {
  // searched for 1.5 ms too late, the impact loses its beginning at the window's edge; the window is then cut again,
  // and no other time is as likely
  const std::vector<float> samples = recording();
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  std::vector<Candidate> impacts;
  for (int k = 0; k < kImpacts; ++k) impacts.push_back({time_of(k), 200.0, 0.4e-3, 50.0});
  const std::vector<bool> clipped(impacts.size(), false);
  const auto learned = estimate_template(sound, audio::learn_ar_models(sound, 48).noise, impacts, clipped);
  ASSERT_TRUE(learned);
  ImpactTimer timer(sound, *learned);
  const ImpactFit near = timer.time(time_of(10), 1e-4, time_of(11));
  const ImpactFit far = timer.time(time_of(10) + 1.5e-3, 4e-3, time_of(11));
  EXPECT_NEAR(far.t_s, near.t_s, 0.1 * near.sigma_s);
  EXPECT_NEAR(far.log_likelihood_ratio / near.log_likelihood_ratio, 1.0, 0.01);
  ASSERT_FALSE(near.log_likelihood_ratio < 10.0 * kUnambiguousLogOdds);
  EXPECT_TRUE(far.alternatives.empty());
}

}  // namespace
}  // namespace bouncelab::detection
