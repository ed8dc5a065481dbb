// SPDX-License-Identifier: GPL-3.0-or-later
// Sounds that come in rows and are no ball: voices, hands, feet, drums, clocks. No track is found, or
// one that states its doubt.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "support/bouncing_sound.hpp"
#include "support/statistics.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
constexpr double kDuration_s = 30.0;
const auto kSeeds = test::repetitions<std::uint64_t>(3, 10);

std::vector<float> silence() { return std::vector<float>(static_cast<std::size_t>(kDuration_s * kRate_hz), 0.0F); }

/// A clap, a key, a step.
void add_burst(std::vector<float>& x, double t_s, double amplitude, double f_hz, double decay_s, Random& random) {
  test::add_noise_burst(x, kRate_hz, t_s, amplitude, {f_hz, decay_s}, random);
}

/// Glottal pulses of a gliding pitch through three formants, in syllables of 80 to 300 ms, some behind a burst.
std::vector<float> speech(Random& random) {
  constexpr double kVowels_hz[4][3] = {{730, 1090, 2440}, {270, 2290, 3010}, {300, 870, 2240}, {530, 1840, 2480}};
  std::vector<float> x = silence();
  const double pitch_hz = random.uniform(90.0, 220.0);
  for (double t_s = 0.3; t_s < kDuration_s - 1.0;) {
    if (random.uniform() < 0.5) add_burst(x, t_s, random.uniform(0.1, 0.6), random.uniform(2e3, 6e3), 5e-3, random);
    const double length_s = random.uniform(0.08, 0.3);
    const double* vowel_hz = kVowels_hz[static_cast<int>(random.uniform(0.0, 4.0))];
    const double glide = random.uniform(-0.3, 0.3);
    for (double pulse_s = 0.0; pulse_s < length_s;) {
      const double envelope = std::sin(kPi * pulse_s / length_s);
      const auto first = static_cast<std::size_t>((t_s + pulse_s) * kRate_hz);
      test::ModalSound formants{{}, 900.0 / kRate_hz};
      for (int f = 0; f < 3; ++f)
        formants.modes.push_back({vowel_hz[f], 1.0 / (kPi * (60.0 + 40.0 * f)), 0.2 / (1 + f)});
      test::add_modal_sound(x, kRate_hz, static_cast<double>(first) / kRate_hz, envelope, formants);
      pulse_s += (1.0 + 0.01 * random.normal()) / (pitch_hz * (1.0 + glide * pulse_s / length_s));
    }
    t_s += length_s + (random.uniform() < 0.8 ? 0.04 * random.exponential() : random.uniform(0.2, 0.9));
  }
  return x;
}

/// A row of hits whose intervals grow or shrink by `tempo` and scatter by `scatter`, again and again.
std::vector<float> rows(Random& random, double interval_s, double scatter, double tempo, int n, double f_hz,
                        double decay_s) {
  std::vector<float> x = silence();
  for (double t_s = 0.4; t_s < kDuration_s - 1.0; t_s += random.uniform(0.5, 1.5)) {
    double step_s = interval_s * random.uniform(0.8, 1.2);
    for (int k = 0; k < n && t_s < kDuration_s - 1.0; ++k, step_s *= tempo) {
      add_burst(x, t_s, std::exp(0.3 * random.normal()), f_hz, decay_s, random);
      t_s += step_s * (1.0 + scatter * random.normal());
    }
  }
  return x;
}

std::vector<float> typing(Random& random) {
  std::vector<float> x = silence();
  for (double t_s = 0.4; t_s < kDuration_s - 1.0;) {
    const double amplitude = std::exp(0.4 * random.normal());
    add_burst(x, t_s, amplitude, random.uniform(1500.0, 5000.0), 3e-3, random);
    add_burst(x, t_s + random.uniform(0.05, 0.11), 0.4 * amplitude, random.uniform(1500.0, 5000.0), 4e-3, random);
    t_s += 0.15 * std::exp(0.4 * random.normal()) + (random.uniform() < 0.1 ? 1.0 : 0.0);
  }
  return x;
}

/// Handling: bunches of four to eight sounds at random within three seconds, then quiet.
std::vector<float> bunches(Random& random) {
  std::vector<float> x = silence();
  for (double t_s = 0.4; t_s < kDuration_s - 5.0; t_s += 5.0) {
    const int n = static_cast<int>(random.uniform(4.0, 9.0));
    for (int k = 0; k < n; ++k)
      add_burst(x, t_s + random.uniform(0.0, 3.0), std::exp(0.6 * random.normal()), random.uniform(100.0, 5000.0), 8e-3,
                random);
  }
  return x;
}

template <class Make>
Detection detected(const std::string& what, std::uint64_t seed, const Make& make) {
  Random random(seed, RandomStream::test, 7);
  std::vector<float> x = make(random);
  test::add_noise(x, 5e-4, seed);
  Detection d = detect(x, kRate_hz, what);
  EXPECT_GT(d.summary.n_candidates, 10) << what << ", seed " << seed << ": no candidates";
  return d;
}

/// Some of it may be shown, with its doubt: chance reaches odds of q in no more than one recording in q.
template <class Make>
void expect_no_train(const std::string& what, const Make& make) {
  double n_beyond_doubt = 0.0;
  std::string drops;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed)
    for (const DropSummary& drop : detected(what, seed, make).drops) {
      n_beyond_doubt += drop.is_doubtful() ? 0.0 : 1.0;
      drops += " seed " + std::to_string(seed) + " odds " + std::to_string(drop.odds);
    }
  EXPECT_LE(n_beyond_doubt, static_cast<double>(kSeeds) / DropSummary::kDoubtfulOdds) << what << ":" << drops;
}

TEST(DetectNoBall, TakesNoSpeechForABall) { expect_no_train("speech", speech); }
TEST(DetectNoBall, TakesNoTypingForABall) { expect_no_train("typing", typing); }

TEST(DetectNoBall, TakesNoRowsOfHitsForABall) {
  expect_no_train("clapping", [](Random& r) { return rows(r, 0.35, 0.05, 1.0, 9, 1500.0, 10e-3); });
  expect_no_train("steps", [](Random& r) { return rows(r, 0.55, 0.04, 1.0, 20, 150.0, 30e-3); });
  expect_no_train("drum roll", [](Random& r) { return rows(r, 0.12, 0.02, 1.0, 25, 190.0, 80e-3); });
  expect_no_train("ritardando", [](Random& r) { return rows(r, 0.4, 0.001, 1.03, 14, 2500.0, 10e-3); });
}

TEST(DetectNoBall, TakesHandlingForABallNoMoreOftenThanItsOddsAllow) {
  // Six sounds at random hold twenty triples and fifteen fours. In some of them the intervals shrink and the loudness
  // falls as those of a ball do, and nothing that could be measured tells these from a drop of so few impacts. What
  // can be asked is that they state their doubt: chance reaches odds of q in no more than one bunch in q.
  constexpr std::uint64_t kManySeeds = 6;
  constexpr double kBunches = 5.0 * kManySeeds;
  double n_beyond_doubt = 0.0;
  for (std::uint64_t seed = 1; seed <= kManySeeds; ++seed)
    for (const DropSummary& drop : detected("handling", seed, [](Random& r) { return bunches(r); }).drops) {
      EXPECT_LE(drop.n_impacts, 4) << "seed " << seed << ", odds " << drop.odds;
      n_beyond_doubt += drop.is_doubtful() ? 0.0 : 1.0;
    }
  EXPECT_LE(n_beyond_doubt, kBunches / DropSummary::kDoubtfulOdds);
}

}  // namespace
}  // namespace bouncelab::detection
