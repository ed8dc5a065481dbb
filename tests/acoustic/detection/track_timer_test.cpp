// SPDX-License-Identifier: GPL-3.0-or-later
// Tracks whose candidates have gaps, end early or go on where nothing sounds.
#include "delay/track_timer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
constexpr int kImpacts = 24;
constexpr double kEps = 0.97;

double time_of(int k) { return 0.3 + 0.3 * (1.0 - std::pow(kEps, k)) / (1.0 - kEps); }

/// A sound of the same plate that is none of the ball's.
struct Knock {
  double t_s = 0.0;
  double amplitude = 0.0;
};

/// A ball of 24 impacts in noise; timed by the candidates of some of them and of instants at which nothing sounds.
/// @param late_s  of the candidates of single impacts
std::vector<TimedImpact> timed(const std::vector<int>& with_candidate, const std::vector<Knock>& knocks = {},
                               const std::map<int, double>& late_s = {}) {
  std::vector<float> samples(static_cast<std::size_t>((time_of(kImpacts) + 0.6) * kRate_hz));
  Random random(7, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(2e-3 * random.normal());
  const test::ModalSound plate = test::equal_modes({2100.0, 5300.0, 7700.0}, 3e-3, 0.05);
  for (int k = 0; k < kImpacts; ++k)
    test::add_modal_sound(samples, kRate_hz, time_of(k), 0.2 * std::pow(kEps, k), plate);
  for (const Knock& knock : knocks) test::add_modal_sound(samples, kRate_hz, knock.t_s, knock.amplitude, plate);
  const audio::AudioSource sound = audio::source_in_memory(samples, kRate_hz);
  std::vector<Candidate> candidates, sounding;
  Track track;
  for (const int k : with_candidate) {
    // the track itself is not sure of the instants at the end at which nothing sounds
    track.impacts.push_back({candidates.size(), k, k < kImpacts ? 1.0 : 0.5});
    const auto late = late_s.find(k);
    candidates.push_back({time_of(k) + (late == late_s.end() ? 0.0 : late->second), 200.0, 0.4e-3, 50.0});
    if (k < kImpacts) sounding.push_back(candidates.back());
    for (const Knock& knock : knocks)  // candidates of no track
      if (knock.t_s > time_of(k) && knock.t_s < time_of(k + 1)) candidates.push_back({knock.t_s, 300.0, 0.4e-3, 50.0});
  }
  WhiteSound white(sound);
  const std::optional<ImpactTemplate> learned =
      estimate_template(white, learn_ar_models(sound, 48).noise, sounding, std::vector<bool>(sounding.size()));
  EXPECT_TRUE(learned);
  return learned ? time_track(white, *learned, track, candidates, time_of(kImpacts) + 0.5) : std::vector<TimedImpact>{};
}

void expect_all_impacts(const std::vector<TimedImpact>& impacts) {
  ASSERT_EQ(impacts.size(), kImpacts);
  const double offset_s = impacts[0].fit.t_s - time_of(0);
  for (int k = 0; k < kImpacts; ++k) {
    EXPECT_EQ(impacts[static_cast<std::size_t>(k)].impact, k);
    EXPECT_NEAR(impacts[static_cast<std::size_t>(k)].fit.t_s - offset_s, time_of(k), 20e-6) << k;
  }
}

TEST(TrackTimer, FindsTheImpactsThatAreMissingBetweenCandidates) {
  const std::vector<TimedImpact> impacts =
      timed({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 15, 16, 18, 19, 20, 21, 22, 23});
  expect_all_impacts(impacts);
  for (const TimedImpact& impact : impacts)
    EXPECT_EQ(impact.inferred, impact.impact == 10 || impact.impact == 11 || impact.impact == 17) << impact.impact;
}

TEST(TrackTimer, GoesOnBeyondTheLastCandidateAsLongAsTheBallSounds) {
  const std::vector<TimedImpact> impacts = timed({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  expect_all_impacts(impacts);
  // a single one has odds of 10 to 1 at most; one with more behind it in their places, of 100 to 1 and more
  for (const TimedImpact& impact : impacts) {
    if (!impact.inferred) continue;
    EXPECT_GT(impact.probability, impact.impact + 1 < kImpacts ? 0.98 : 0.9) << impact.impact;
  }
}

TEST(TrackTimer, StaysAtTheImpactWhereALouderKnockOfTheSamePlateFollows) {
  std::vector<int> all;
  for (int k = 0; k < kImpacts; ++k) all.push_back(k);
  for (const double later_s : {6e-3, 9e-3, 13e-3, 19e-3})
    expect_all_impacts(timed(all, {{time_of(6) + later_s, 0.35}, {time_of(15) + later_s, 0.25}}));
}

TEST(TrackTimer, PutsAnImpactWhereItsNeighboursExpectItThoughItsCandidateIsAKnockFarBehind) {
  std::vector<int> all;
  for (int k = 0; k < kImpacts; ++k) all.push_back(k);
  for (const double late_s : {8e-3, 11e-3, 16e-3}) {
    SCOPED_TRACE(late_s);
    expect_all_impacts(timed(all, {{time_of(14) + late_s, 0.05}}, {{14, late_s}}));
  }
}

TEST(TrackTimer, FindsAMissingImpactThoughTheCandidateBehindItIsLate) {
  std::vector<int> all_but_one;
  for (int k = 0; k < kImpacts; ++k)
    if (k != 14) all_but_one.push_back(k);
  expect_all_impacts(timed(all_but_one, {{time_of(15) + 11e-3, 0.05}}, {{15, 11e-3}}));
}

}  // namespace
}  // namespace bouncelab::detection
