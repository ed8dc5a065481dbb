// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/impact_timer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/random.hpp"
#include "delay/delay_model.hpp"
#include "support/modal_sound.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
constexpr int kImpacts = 20;

double time_of(int k) { return 0.2 + 0.25 * k + 1e-5 * k * k; }

/// Adds three damped modes from t_s on.
void add_impact(std::vector<float>& samples, double t_s) {
  test::add_modal_sound(samples, kRate_hz, t_s, 0.2, test::equal_modes({2100.0, 5300.0, 7700.0}, 3e-3, 0.05));
}

/// Twenty impacts in noise.
std::vector<float> recording() {
  std::vector<float> samples(static_cast<std::size_t>(5.5 * kRate_hz));
  Random random(7, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(1e-2 * random.normal());
  for (int k = 0; k < kImpacts; ++k) add_impact(samples, time_of(k));
  return samples;
}

std::optional<ImpactTemplate> template_of(const audio::AudioSource& sound) {
  std::vector<Candidate> impacts;
  for (int k = 0; k < kImpacts; ++k) impacts.push_back({time_of(k), 200.0, 0.4e-3, 50.0});
  const std::vector<bool> clipped(impacts.size(), false);
  WhiteSound white(sound);
  return estimate_template(white, learn_ar_models(sound, 48).noise, impacts, clipped);
}

TEST(ImpactTimer, GivesTheSameMarginToAnImpactFoundFarFromWhereItWasExpected) {
  // searched for 1.5 ms too late, the impact loses its beginning at the window's edge; the window is then cut again,
  // and no other time is as likely
  const std::vector<float> samples = recording();
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  const std::optional<ImpactTemplate> learned = template_of(sound);
  ASSERT_TRUE(learned);
  WhiteSound white(sound);
  ImpactTimer timer(white, *learned);
  const ImpactFit near = timer.time(time_of(10), 1e-4, time_of(11));
  const ImpactFit far = timer.time(time_of(10) + 1.5e-3, 4e-3, time_of(11));
  EXPECT_NEAR(far.t_s, near.t_s, 0.1 * near.sigma_s);
  EXPECT_NEAR(far.log_likelihood_ratio / near.log_likelihood_ratio, 1.0, 0.01);
  ASSERT_FALSE(near.log_likelihood_ratio < 10.0 * kDelay.unambiguous);
  EXPECT_TRUE(far.alternatives.empty());
}

TEST(ImpactTimer, IsDisturbedByWhatIsUnexplainedAtTheFrequenciesOfTheTemplateOnly) {
  const auto disturbance = [](double other_hz) {
    std::vector<float> samples = recording();
    const auto other = test::equal_modes({other_hz}, 1e-3, 0.05);
    test::add_modal_sound(samples, kRate_hz, time_of(10) + 6e-3, 0.3, other);
    const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
    const std::vector<float> clean = recording();
    const std::optional<ImpactTemplate> learned = template_of(audio::source_in_memory(clean, kRate_hz));
    WhiteSound white(sound);
    return learned ? ImpactTimer(white, *learned).time(time_of(10), 1e-4, time_of(11)).disturbance : 0.0;
  };
  EXPECT_GT(disturbance(5300.0), 10.0 * disturbance(14e3));
}

/// The same template where the unit of the whitened sound is `factor` times larger: a codec leaves less between impacts
/// than the share of their power that is taken to be different each time.
ImpactTemplate in_larger_units(ImpactTemplate learned, float factor) {
  for (float& c : learned.whitener) c /= factor;
  audio::Spectrum spectrum = learned.filter.spectrum();
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    spectrum.re[k] /= factor;
    spectrum.im[k] /= factor;
  }
  learned.filter = MatchedFilter(spectrum, learned.filter.n_window());
  for (double& noise : learned.subbands.noise) noise /= factor * factor;
  return learned;
}

TEST(ImpactTimer, IsAsSureOfAFaintImpactWhereTheBackgroundIsFarBelowTheWhitenersUnit) {
  std::vector<float> samples = recording();
  constexpr double kFaint_s = 5.3;
  test::add_modal_sound(samples, kRate_hz, kFaint_s, 0.1, test::equal_modes({2100.0, 5300.0, 7700.0}, 3e-3, 0.05));
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  const std::optional<ImpactTemplate> learned = template_of(sound);
  ASSERT_TRUE(learned);
  const ImpactTemplate other = in_larger_units(*learned, 20.0F);
  WhiteSound white(sound);
  const ImpactFit before = ImpactTimer(white, *learned).time(kFaint_s, 2e-3, 5.4);
  const ImpactFit after = ImpactTimer(white, other).time(kFaint_s, 2e-3, 5.4);
  EXPECT_NEAR(after.t_s, before.t_s, 1e-9);
  EXPECT_NEAR(after.sigma_s / before.sigma_s, 1.0, 1e-3);
  EXPECT_NEAR(after.log_likelihood_ratio / after.disturbance / (before.log_likelihood_ratio / before.disturbance), 1.0,
              0.6);
  EXPECT_NEAR(after.log_likelihood_ratio / after.noise / (before.log_likelihood_ratio / before.noise), 1.0, 0.3);
  EXPECT_EQ(after.alternatives.size(), before.alternatives.size());
}

TEST(ImpactTimer, SubtractsKnownImpactsInAnyOrder) {
  // a third impact in the ringing of two others, 4 and 8 ms before it
  const double first_s = time_of(10), second_s = first_s + 4e-3, third_s = first_s + 8e-3;
  std::vector<float> samples = recording();
  add_impact(samples, second_s);
  add_impact(samples, third_s);
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  const std::optional<ImpactTemplate> learned = template_of(sound);
  ASSERT_TRUE(learned);
  WhiteSound white(sound);
  const ImpactFit alone = ImpactTimer(white, *learned).time(time_of(5), 1e-4, time_of(6));
  const double onset_s = alone.t_s - time_of(5);  // where in the template contact begins
  ImpactFit first = alone, second = alone;
  first.t_s = first_s + onset_s;
  second.t_s = second_s + onset_s;
  ImpactTimer forward(white, *learned);
  forward.subtract_from_later(first);
  forward.subtract_from_later(second);
  ImpactTimer backward(white, *learned);
  backward.subtract_from_later(second);
  backward.subtract_from_later(first);
  const ImpactFit a = forward.time(third_s, 1e-4, time_of(11));
  const ImpactFit b = backward.time(third_s, 1e-4, time_of(11));
  EXPECT_NEAR(a.t_s, b.t_s, 1e-3 * a.sigma_s);  // rounding of sums in single precision
  EXPECT_NEAR(a.t_s - onset_s, third_s, 4.0 * std::hypot(a.sigma_s, alone.sigma_s));  // four standard errors
}

}  // namespace
}  // namespace bouncelab::detection
