// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "hosted_plugin.hpp"
#include "support/bouncing_sound.hpp"

namespace bouncelab::test {
namespace {

constexpr double kRate_hz = 48e3;

std::vector<float> drop_of_ball() {
  BouncingSound sound;
  sound.n_impacts = 20;
  return render(sound);
}

detection::Detection detected(const std::vector<float>& sound) {
  return detection::detect(sound, kRate_hz, "recording");
}

std::int64_t nanoseconds_of(double t_s) { return std::llround(t_s * 1e9); }

Features features_of(const std::string& name, const std::vector<float>& sound, std::size_t step, std::size_t block) {
  const auto plugin = hosted(name, static_cast<float>(kRate_hz));
  EXPECT_TRUE(plugin->initialise(1, step, block));
  return run(*plugin, sound, step, block);
}

void expect_impacts(Features& features, const Onsets& onsets) {
  ASSERT_EQ(features[0].size(), onsets.size());
  std::size_t n_sigmas = 0, n_probabilities = 0;
  for (std::size_t k = 0; k < onsets.size(); ++k) {
    const Onset& onset = onsets[k];
    EXPECT_EQ(nanoseconds(features[0][k].timestamp), nanoseconds_of(onset.t_s));
    EXPECT_TRUE(features[0][k].values.empty());
    EXPECT_EQ(features[0][k].label.substr(0, features[0][k].label.rfind(", impact")),
              "drop " + std::to_string(onset.drop));
    if (onset.sigma_t_s) {
      ASSERT_LT(n_sigmas, features[1].size());
      EXPECT_EQ(nanoseconds(features[1][n_sigmas].timestamp), nanoseconds_of(onset.t_s));
      EXPECT_THAT(features[1][n_sigmas++].values, testing::ElementsAre(static_cast<float>(*onset.sigma_t_s)));
    }
    if (onset.probability) {
      ASSERT_LT(n_probabilities, features[2].size());
      EXPECT_THAT(features[2][n_probabilities++].values, testing::ElementsAre(static_cast<float>(*onset.probability)));
    }
  }
  EXPECT_EQ(n_sigmas, features[1].size());
  EXPECT_EQ(n_probabilities, features[2].size());
  EXPECT_GT(n_sigmas, 0u);
  EXPECT_GT(n_probabilities, 0u);
}

void expect_samples(Features& features, const RestitutionSamples& samples) {
  ASSERT_EQ(features[0].size(), samples.size());
  ASSERT_EQ(features[2].size(), samples.size());
  std::size_t n_sigmas = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    EXPECT_EQ(nanoseconds(features[0][k].timestamp), nanoseconds_of(samples[k].t_s));
    EXPECT_THAT(features[0][k].values, testing::ElementsAre(static_cast<float>(samples[k].eps)));
    EXPECT_THAT(features[2][k].values, testing::ElementsAre(static_cast<float>(samples[k].v_mps)));
    if (!samples[k].sigma_eps) continue;
    ASSERT_LT(n_sigmas, features[1].size());
    EXPECT_THAT(features[1][n_sigmas++].values, testing::ElementsAre(static_cast<float>(*samples[k].sigma_eps)));
  }
  EXPECT_EQ(n_sigmas, features[1].size());
  EXPECT_GT(n_sigmas, 0u);
}

/// Blocks as hosts choose them, the last one overlapping: the times are to the nanosecond, the values to the float,
/// because the samples that the detector gets are the recording's.
class VampBlocks : public testing::TestWithParam<std::pair<std::size_t, std::size_t>> {};

TEST_P(VampBlocks, ImpactsAreThoseOfTheDetectorToTheNanosecond) {
  const std::vector<float> sound = drop_of_ball();
  const detection::Detection found = detected(sound);
  ASSERT_GE(found.onsets.size(), 18u);
  Features features = features_of("impacts", sound, GetParam().first, GetParam().second);
  expect_impacts(features, found.onsets);
  ASSERT_EQ(features[3].size(), found.drops.size());
  EXPECT_THAT(features[3][0].values, testing::ElementsAre(static_cast<float>(found.drops[0].odds)));
  EXPECT_EQ(nanoseconds(features[3][0].timestamp + features[3][0].duration), nanoseconds_of(found.onsets.back().t_s));
}

INSTANTIATE_TEST_SUITE_P(AsHostsChooseThem, VampBlocks, testing::Values(std::pair{256, 256}, std::pair{1000, 1024}));

TEST(VampPlugins, RestitutionIsThatOfTheSamplesAndCorrectedForDragOfANamedBall) {
  const std::vector<float> sound = drop_of_ball();
  Features of_no_ball = features_of("restitution", sound, 1024, 1024);
  expect_samples(of_no_ball, fit::restitution_samples(detected(sound).onsets, {}).samples);
  const auto plugin = hosted("restitution", static_cast<float>(kRate_hz));
  const auto kinds = ball_kinds();
  const auto steel = std::find_if(kinds.begin(), kinds.end(), [](const BallKind& k) { return k.name == "steel"; });
  plugin->setParameter("ball", static_cast<float>(steel - kinds.begin() + 1));
  plugin->setParameter("diameter", 6.35F);
  plugin->setParameter("gravity", 9.7F);
  ASSERT_TRUE(plugin->initialise(1, 1024, 1024));
  Features features = run(*plugin, sound, 1024, 1024);
  detection::DetectionConfig detector;
  detector.gravity_mps2 = 9.7;
  fit::RestitutionConfig config;
  config.gravity_mps2 = 9.7;
  config.ball = ball_from_text("steel:6.35mm");
  const Onsets onsets = detection::detect(sound, kRate_hz, "recording", detector).onsets;
  expect_samples(features, fit::at_the_plate(fit::restitution_samples(onsets, config).samples));
  // the correction is there at all
  EXPECT_NE(features[0][0].values[0], static_cast<float>(fit::restitution_samples(onsets, config).samples[0].eps));
}

TEST(VampPlugins, TwoAtOnceKeepTheirOwnRecordings) {
  const std::vector<float> one = drop_of_ball();
  BouncingSound sound;
  sound.n_impacts = 12;
  sound.seed = 7;
  const std::vector<float> other = render(sound);
  const auto first = hosted("impacts", static_cast<float>(kRate_hz));
  const auto second = hosted("impacts", static_cast<float>(kRate_hz));
  ASSERT_TRUE(first->initialise(1, 512, 512));
  ASSERT_TRUE(second->initialise(1, 512, 512));
  for (std::size_t begin = 0; begin + 512 <= std::min(one.size(), other.size()); begin += 512) {
    const float* of_one = one.data() + begin;
    const float* of_other = other.data() + begin;
    const Vamp::RealTime now = Vamp::RealTime::frame2RealTime(static_cast<long>(begin), 48000);
    first->process(&of_one, now);
    second->process(&of_other, now);
  }
  const std::size_t n = std::min(one.size(), other.size()) / 512 * 512;
  Features of_one = first->getRemainingFeatures(), of_other = second->getRemainingFeatures();
  expect_impacts(of_one, detected({one.begin(), one.begin() + static_cast<std::ptrdiff_t>(n)}).onsets);
  expect_impacts(of_other, detected({other.begin(), other.begin() + static_cast<std::ptrdiff_t>(n)}).onsets);
}

TEST(VampPlugins, ResetForgetsTheRecordingAndItsBeginFromWhichTimesCount) {
  const std::vector<float> sound = drop_of_ball();
  const Onsets onsets = detected(sound).onsets;
  const auto plugin = hosted("impacts", static_cast<float>(kRate_hz));
  ASSERT_TRUE(plugin->initialise(1, 1024, 1024));
  Features features = run(*plugin, sound, 1024, 1024, Vamp::RealTime(7, 125'000'001));
  ASSERT_EQ(features[0].size(), onsets.size());
  EXPECT_EQ(nanoseconds(features[0][0].timestamp), nanoseconds_of(onsets[0].t_s) + 7'125'000'001);
  plugin->reset();
  features = run(*plugin, sound, 1024, 1024);
  expect_impacts(features, onsets);
}

}  // namespace
}  // namespace bouncelab::test
