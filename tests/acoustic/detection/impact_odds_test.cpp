// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/detection/detect.hpp"
#include "support/bouncing_sound.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::detection {
namespace {

/// A recording of some seconds: in two of three a ball of 3 to 12 impacts, in which eps and loudness scatter and one
/// impact in twelve makes no sound; knocks of the same plate and other noises anywhere.
struct Scene {
  static constexpr double kRate_hz = 22050.0;
  std::vector<float> sound;
  std::vector<double> impacts_s;
};

Scene scene(std::uint64_t seed) {
  Random random(seed, RandomStream::test, 11);
  Scene s;
  s.sound.resize(static_cast<std::size_t>(4.5 * Scene::kRate_hz));
  const double clutter_per_s = random.uniform() < 0.3 ? 0.3 : random.uniform(0.5, 5.0);
  if (random.uniform() < 0.67) {
    const auto n_impacts = static_cast<int>(random.uniform(3.0, 13.0));
    const double eps = random.uniform(0.55, 0.93);
    const double scatter = random.uniform(0.003, 0.03);
    double flight_s = random.uniform(0.25, 0.7);
    double t_s = random.uniform(0.2, 1.5);
    const double loudness = 0.5 / flight_s;
    for (int k = 0; k < n_impacts && flight_s > 15e-3 && t_s < 4.3; ++k) {
      const double amplitude = loudness * flight_s * std::exp(0.3 * random.normal());
      if (random.uniform() < 0.92) {
        s.impacts_s.push_back(t_s);
        test::add_impact(s.sound, Scene::kRate_hz, t_s, amplitude);
      }
      t_s += flight_s;
      flight_s *= eps * std::exp(scatter * random.normal());
    }
  }
  const auto n_clutter = static_cast<int>(clutter_per_s * 4.5 * random.uniform(0.7, 1.3));
  for (int k = 0; k < n_clutter; ++k) {
    const double t_s = random.uniform(0.05, 4.3);
    const double amplitude = 0.2 * std::exp(0.8 * random.normal());
    if (random.uniform() < 0.5)
      test::add_impact(s.sound, Scene::kRate_hz, t_s, amplitude);
    else
      test::add_noise_burst(s.sound, Scene::kRate_hz, t_s, amplitude, {600.0, 10e-3, 1.0}, random);
  }
  test::add_noise(s.sound, std::exp(random.uniform(std::log(1e-3), std::log(2e-2))), seed);
  return s;
}

struct Mark {
  double probability = 0.0;
  bool is_right = false;
};

/// Marks of one recording; right is one within 3 ms of an impact, since there may be no template.
void add_marks(std::uint64_t seed, std::vector<Mark>& marks) {
  const Scene s = scene(seed);
  for (const Onset& onset : detect(s.sound, Scene::kRate_hz, "scene").onsets) {
    const bool is_right = std::any_of(s.impacts_s.begin(), s.impacts_s.end(),
                                      [&](double t_s) { return std::abs(t_s - onset.t_s) < 3e-3; });
    marks.push_back({onset.probability.value(), is_right});
  }
}

/// Marks whose stated probability is in a range.
struct Stated {
  double n = 0.0, mean = 0.0, share_right = 0.0;
};

Stated stated_in(const std::vector<Mark>& marks, double from, double to) {
  Stated stated;
  for (const Mark& mark : marks) {
    if (mark.probability < from || mark.probability >= to) continue;
    stated.n += 1.0;
    stated.mean += mark.probability;
    stated.share_right += mark.is_right ? 1.0 : 0.0;
  }
  stated.mean /= std::max(1.0, stated.n);
  stated.share_right /= std::max(1.0, stated.n);
  return stated;
}

TEST(ImpactOdds, StatedProbabilitiesAreTheSharesThatAreRight) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  std::vector<Mark> marks;
  for (std::uint64_t seed = 1; seed <= 240; ++seed) add_marks(seed, marks);
  constexpr std::array<double, 6> kEdges{0.0, 0.6, 0.9, 0.97, 0.99, 1.0};
  for (std::size_t bin = 0; bin + 1 < kEdges.size(); ++bin) {
    const Stated s = stated_in(marks, kEdges[bin], kEdges[bin + 1]);
    ASSERT_GE(s.n, 20.0) << bin;
    // three standard errors of the share, and what prior odds that are not the scenes' move it by: a factor of three
    const double error = 3.0 * std::sqrt(s.mean * (1.0 - s.mean) / s.n);
    const double odds = s.mean / (1.0 - s.mean);
    EXPECT_GT(s.share_right, odds / (3.0 + odds) - error) << "stated " << s.mean << " of " << s.n;
    EXPECT_LT(s.share_right, 3.0 * odds / (1.0 + 3.0 * odds) + error) << "stated " << s.mean << " of " << s.n;
  }
  // and not one share for all of them
  EXPECT_LT(stated_in(marks, 0.0, 0.6).share_right, 0.85);
  // stated are 0.9985: three standard errors of some 600 below it
  EXPECT_GT(stated_in(marks, 0.99, 1.1).share_right, 0.994);
}

TEST(ImpactOdds, ThreeImpactsAreADropOfLowOddsAndManyOneOfHigh) {
  test::BouncingSound ball;
  ball.rate_hz = 44100.0;
  ball.eps = 0.75;
  ball.first_flight_s = 0.5;
  ball.n_impacts = 3;
  const Detection three = detect(render(ball), ball.rate_hz, "three");
  ASSERT_EQ(three.drops.size(), 1u);
  EXPECT_EQ(three.drops[0].n_impacts, 3);
  EXPECT_GE(three.drops[0].odds, 1.0);
  ball.n_impacts = 9;
  const Detection nine = detect(render(ball), ball.rate_hz, "nine");
  ASSERT_EQ(nine.drops.size(), 1u);
  EXPECT_NEAR(nine.drops[0].begin_s, ball.first_s, 1e-3);
  EXPECT_FALSE(nine.drops[0].is_doubtful());
  EXPECT_GT(nine.drops[0].odds, 10.0 * three.drops[0].odds);
  EXPECT_GT(nine.onsets[4].probability.value(), 0.99);
}

TEST(ImpactOdds, DropsOfFewerImpactsThanAskedForAreLeftOutAndTheOthersNumberedAnew) {
  test::BouncingSound ball;
  ball.rate_hz = 44100.0;
  ball.eps = 0.75;
  ball.first_flight_s = 0.5;
  ball.n_impacts = 4;
  std::vector<float> sound = render(ball);
  ball.n_impacts = 9;
  const std::vector<float> longer = render(ball);
  sound.insert(sound.end(), longer.begin(), longer.end());
  EXPECT_EQ(detect(sound, ball.rate_hz, "two").drops.size(), 2u);
  DetectionConfig config;
  config.min_impacts = 6;
  const Detection d = detect(sound, ball.rate_hz, "one", config);
  ASSERT_EQ(d.drops.size(), 1u);
  EXPECT_EQ(d.summary.n_drops, 1);
  EXPECT_EQ(d.drops[0].n_impacts, std::ssize(d.onsets));
  for (const Onset& onset : d.onsets) EXPECT_EQ(onset.drop, 0);
  config.min_impacts = 100;
  const Detection none = detect(sound, ball.rate_hz, "none", config);
  EXPECT_EQ(none.status, DetectionStatus::too_few_impacts);
  EXPECT_FALSE(none.summary.contact_time_sigma_s.has_value());
}

}  // namespace
}  // namespace bouncelab::detection
