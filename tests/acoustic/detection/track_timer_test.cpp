// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/track_timer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

/// A smooth track, each impact with alternatives a cycle before and after it.
std::vector<TimedImpact> track_with_alternatives(double log_odds_margin) {
  std::vector<TimedImpact> impacts;
  double t_s = 0.0;
  double flight_s = 0.15;
  for (int k = 0; k < 30; ++k) {
    TimedImpact impact;
    impact.impact = k;
    impact.fit.t_s = t_s;
    impact.fit.alternatives = {{t_s + 0.4e-3, log_odds_margin}, {t_s - 0.4e-3, log_odds_margin}};
    impacts.push_back(impact);
    t_s += flight_s;
    flight_s *= 0.95 + 2e-4 * std::sin(7.0 * k);
  }
  return impacts;
}

std::size_t best_of(const HypothesisProbabilities& p) {
  return static_cast<std::size_t>(std::max_element(p.begin(), p.end()) - p.begin());
}

TEST(DelayPosterior, PutsASlippedImpactBackWhereTheTrackIsSmooth) {
  // of three times the least likely by sound
  std::vector<TimedImpact> impacts = track_with_alternatives(20.0);
  ImpactFit& slipped = impacts[12].fit;
  std::swap(slipped.t_s, slipped.alternatives[1].t_s);
  slipped.alternatives[0].log_odds_margin = 0.5;
  slipped.alternatives[1].log_odds_margin = 1.0;
  const std::vector<HypothesisProbabilities> p = delay_posterior(impacts);
  for (std::size_t k = 0; k < impacts.size(); ++k) EXPECT_EQ(best_of(p[k]), k == 12 ? 2U : 0U) << k;
  EXPECT_GT(p[12][2], 0.99);
}

/// The posterior as the sum over every combination of hypotheses.
std::vector<HypothesisProbabilities> enumerated(const std::vector<TimedImpact>& track,
                                                const std::vector<ExpectedLogEps>& expected) {
  std::vector<HypothesisProbabilities> p;
  for (const TimedImpact& impact : track) p.emplace_back(n_hypotheses(impact), 0.0);
  std::vector<std::size_t> h(track.size(), 0);
  double all = 0.0;
  for (bool is_more = true; is_more;) {
    double density = 1.0;
    for (std::size_t k = 0; k < track.size(); ++k)
      if (h[k] > 0) density *= std::exp(-track[k].fit.alternatives[h[k] - 1].log_odds_margin);
    for (std::size_t k = 1; k + 1 < track.size(); ++k) {
      if (expected[k].width == 0.0) continue;
      const double before_s = hypothesis_time(track[k], h[k]) - hypothesis_time(track[k - 1], h[k - 1]);
      const double after_s = hypothesis_time(track[k + 1], h[k + 1]) - hypothesis_time(track[k], h[k]);
      const double z = (std::log(after_s / before_s) - expected[k].centre) / expected[k].width;
      density *= std::pow(1.0 + 0.25 * z * z, -2.5);
    }
    all += density;
    for (std::size_t k = 0; k < track.size(); ++k) p[k][h[k]] += density;
    std::size_t k = 0;
    while (k < h.size() && ++h[k] == p[k].size()) h[k++] = 0;
    is_more = k < h.size();
  }
  for (HypothesisProbabilities& of_impact : p)
    for (double& x : of_impact) x /= all;
  return p;
}

TEST(DelayPosterior, EqualsTheSumOverAllCombinationsInSmallCases) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed, RandomStream::test, 40);
    std::vector<TimedImpact> track;
    std::vector<ExpectedLogEps> expected;
    double t_s = 0.0;
    const int n_impacts = 2 + static_cast<int>(5.0 * random.uniform());
    for (int k = 0; k < n_impacts; ++k) {
      TimedImpact impact;
      impact.impact = k;
      impact.fit.t_s = t_s;
      const int n_others = static_cast<int>(4.0 * random.uniform());
      for (int j = 0; j < n_others; ++j)
        impact.fit.alternatives.push_back({t_s + 5e-3 * random.normal(), 4.0 * random.uniform()});
      track.push_back(impact);
      expected.push_back({std::log(0.95), random.uniform() < 0.2 ? 0.0 : 0.02});
      t_s += 0.1 * std::pow(0.95, k) + 2e-3 * random.normal();
    }
    const auto p = chain_posterior(track, expected, {});
    const auto reference = enumerated(track, expected);
    for (std::size_t k = 0; k < track.size(); ++k)
      for (std::size_t h = 0; h < p[k].size(); ++h)
        EXPECT_NEAR(p[k][h], reference[k][h], 1e-9) << seed << " " << k << " " << h;
  }
}

TEST(DelayPosterior, PrefersWhereTheSoundRisesUnlessTheRecordingShowsOtherwise) {
  // the sound says little: 1 nat for a place 8 ms behind the rise, where the track is as smooth
  std::vector<TimedImpact> impacts = track_with_alternatives(20.0);
  impacts.resize(5);  // too short for smoothness
  for (TimedImpact& impact : impacts) {
    impact.rise_s = impact.fit.t_s;
    impact.rise_reach_s = 0.4e-3;
    impact.fit.alternatives = {{impact.fit.t_s, 1.0}};
    impact.fit.t_s += 8e-3;
  }
  for (const HypothesisProbabilities& p : delay_posterior(impacts)) EXPECT_EQ(best_of(p), 1U);
  for (TimedImpact& impact : impacts) impact.fit.alternatives[0].log_odds_margin = 12.0;
  for (const HypothesisProbabilities& p : delay_posterior(impacts)) EXPECT_EQ(best_of(p), 0U);
}

TEST(DelayPosterior, AnImpactThatMayBeElsewhereIsLessProbablyWhereItIsPut) {
  TimedImpact impact;
  impact.fit.t_s = 1.0;
  impact.fit.alternatives = {{1.0002, 0.0}, {1.004, 0.0}, {0.999, 0.0}};
  TimedImpact chosen = impact;
  set_doubt(impact, {0.4, 0.3, 0.2, 0.1}, 0, chosen);
  EXPECT_TRUE(chosen.doubtful);
  EXPECT_DOUBLE_EQ(chosen.probability, 0.8) << "a cycle of the same sound is no other";
  EXPECT_NEAR(chosen.doubt_s, std::sqrt(0.3 * 4e-8 + 0.2 * 16e-6 + 0.1 * 1e-6), 1e-12);
}

/// Stated and true squared errors of a track with a ball's single losses (Laplace distributed ln eps, no Student's t),
/// in which every impact may be a cycle of 0.3 ms off: by the sound alone a difference of two normal variables.
struct Squares {
  double error = 0.0, stated = 0.0;
};

Squares squares_of(std::uint64_t seed, double mean_margin) {
  Random random(seed, RandomStream::test, 41);
  std::vector<TimedImpact> track;
  std::vector<double> true_s;
  double t_s = 0.0, flight_s = 0.12;
  for (int k = 0; k < 40; ++k) {
    TimedImpact impact;
    impact.impact = k;
    true_s.push_back(t_s);
    std::vector<DelayHypothesis> places{{t_s, 0.0}, {t_s + 0.3e-3, 0.0}, {t_s - 0.3e-3, 0.0}};
    // log likelihoods: m below on the average, with the variance 2 m that a likelihood ratio then has
    for (std::size_t h = 1; h < 3; ++h)
      places[h].log_odds_margin = mean_margin + std::sqrt(2.0 * mean_margin) * random.normal();
    std::sort(places.begin(), places.end(),
              [](const auto& a, const auto& b) { return a.log_odds_margin < b.log_odds_margin; });
    impact.fit.t_s = places[0].t_s;
    for (std::size_t h = 1; h < 3; ++h)
      impact.fit.alternatives.push_back({places[h].t_s, places[h].log_odds_margin - places[0].log_odds_margin});
    track.push_back(impact);
    t_s += flight_s;
    const double u = random.uniform() - 0.5;
    flight_s *= 0.96 * std::exp(-3e-3 * std::copysign(std::log(1.0 - 2.0 * std::abs(u)), u));
  }
  const std::vector<HypothesisProbabilities> p = delay_posterior(track);
  Squares squares;
  for (std::size_t k = 0; k < track.size(); ++k) {
    const double chosen_s = hypothesis_time(track[k], best_of(p[k]));
    squares.error += (chosen_s - true_s[k]) * (chosen_s - true_s[k]);
    for (std::size_t h = 0; h < p[k].size(); ++h) {
      const double off_s = hypothesis_time(track[k], h) - chosen_s;
      squares.stated += p[k][h] * off_s * off_s;
    }
  }
  return squares;
}

TEST(DelayPosterior, StatesTheErrorThatItsChoicesHaveOverManyTracks) {
  for (const double mean_margin : {0.5, 2.0, 5.0}) {
    Squares all;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      const Squares squares = squares_of(seed, mean_margin);
      all.error += squares.error;
      all.stated += squares.stated;
    }
    EXPECT_GT(all.error, 0.0) << "the case is not one of doubt";
    EXPECT_NEAR(std::sqrt(all.error / all.stated), 1.0, 0.25) << mean_margin;
  }
}

// Tracks whose candidates have gaps, end early or go on where nothing sounds.

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
std::vector<TimedImpact> timed(const std::vector<int>& with_candidate, const std::vector<Knock>& knocks = {}) {
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
    candidates.push_back({time_of(k), 200.0, 0.4e-3, 50.0});
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

}  // namespace

}  // namespace bouncelab::detection
