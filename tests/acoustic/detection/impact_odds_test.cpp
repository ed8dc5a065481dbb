// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/impact_odds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/detection/detect.hpp"
#include "support/bouncing_sound.hpp"

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
  bool is_inferred = false;
};

/// Marks of one recording; right is one within 3 ms of an impact, since there may be no template.
void add_marks(std::uint64_t seed, std::vector<Mark>& marks) {
  const Scene s = scene(seed);
  for (const Onset& onset : detect(s.sound, Scene::kRate_hz, "scene").onsets) {
    const bool is_right = std::any_of(s.impacts_s.begin(), s.impacts_s.end(),
                                      [&](double t_s) { return std::abs(t_s - onset.t_s) < 3e-3; });
    if (onset.flags.has(Flag::inferred)) std::fprintf(stderr,"MARK %d %.4f right %d p %.5f\n",(int)seed,onset.t_s,is_right,*onset.probability);
    marks.push_back({onset.probability.value(), is_right, onset.flags.has(Flag::inferred)});
  }
}

TEST(ImpactOdds, StatedProbabilitiesAreTheSharesThatAreRight) {
  std::vector<Mark> marks;
  for (std::uint64_t seed = 1; seed <= 900; ++seed) add_marks(seed, marks);
  const double edges[] = {0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.97, 0.99, 0.999, 1.0001};
  for (const int inferred : {0, 1})
  for (std::size_t b = 0; b + 1 < std::size(edges); ++b) {
    double n = 0, sum = 0, right = 0;
    for (const Mark& m : marks)
      if (m.is_inferred == (inferred == 1) && m.probability >= edges[b] && m.probability < edges[b + 1]) n += 1, sum += m.probability, right += m.is_right;
    if (n > 0) std::printf("%d %6.3f..%6.3f n %5.0f stated %.4f right %.4f\n", inferred, edges[b], edges[b + 1], n, sum / n, right / n);
  }
}

}  // namespace
}  // namespace bouncelab::detection
