// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/detection/detect.hpp"
#include "candidate_rows.hpp"
#include "support/bouncing_sound.hpp"
#include "support/sanitizers.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/tracker.hpp"

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

// Log odds of given rows of candidates: that of a ball against a rhythm, of overlapping tracks, of few drops in an
// hour.

const SameSource kNone;

bool is_rhythm(const Hypothesis& h) { return h.log_odds_of_rhythm() > h.log_odds_of_losing_ball(); }

/// That all candidates are the impacts of one ball, their own sounds no clutter.
Hypothesis all_of(const std::vector<Candidate>& candidates) {
  const Observations o(candidates, test::kTiming_s, kNone);
  std::vector<std::size_t> own;
  for (std::size_t k = 0; k < candidates.size(); ++k) own.push_back(k);
  Hypothesis h = Hypothesis::begin(o.without(0, own), o.without(1, own), 1.0, false);
  for (std::size_t k = 2; k < candidates.size(); ++k) {
    const std::optional<Hypothesis> longer = test::extended(h, o.without(k, own), 0, 1.0, false);
    EXPECT_TRUE(longer) << "impact " << k;
    if (!longer) return h;
    h = *longer;
  }
  return h;
}

/// A row of sounds whose intervals change by a factor and scatter, as sounds do about their beats or as intervals do.
struct Row {
  int n = 20;
  double interval_s = 0.35;
  double factor = 1.0;
  double beat_scatter = 0.0, interval_scatter = 0.0;
};

std::vector<Candidate> row_of(const Row& row, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 0);
  std::vector<Candidate> candidates;
  double t_s = 1.0, interval_s = row.interval_s;
  for (int k = 0; k < row.n; ++k) {
    const double off_s = row.beat_scatter * interval_s * random.normal();
    candidates.push_back(test::candidate(t_s + off_s, 200.0 * std::exp(0.15 * random.normal())));
    t_s += interval_s * std::exp(row.interval_scatter * random.normal());
    interval_s *= row.factor;
  }
  return candidates;
}

test::BallRow uneven_ball() { return {.n_impacts = 12, .eps_scatter = 0.015, .loudness_scatter = 0.2}; }

TEST(Hypothesis, ABallIsABallAndARhythmNone) {
  const auto followed_by = [](std::vector<Candidate> row, const std::vector<double>& intervals_s, double amplitude) {
    double t_s = row.back().t_s;
    for (const double interval_s : intervals_s) row.push_back(test::candidate(t_s += interval_s, amplitude));
    return row;
  };
  std::vector<double> faster_s(20, 0.25);
  faster_s.resize(40, 0.125);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Hypothesis ball = all_of(test::candidates_of(uneven_ball(), Random(seed, RandomStream::test, 2)));
    EXPECT_FALSE(is_rhythm(ball));
    EXPECT_GT(ball.log_odds_of_ball(), 8.0);
    const Hypothesis metronome = all_of(row_of({.beat_scatter = 1e-3}, seed));
    EXPECT_TRUE(is_rhythm(metronome));
    EXPECT_LT(metronome.log_odds_of_ball(), -8.0);
    const Hypothesis accelerando = all_of(row_of({.factor = 0.97, .interval_scatter = 0.03}, seed));
    EXPECT_TRUE(is_rhythm(accelerando));
    EXPECT_LT(accelerando.log_odds_of_ball(), -2.0);  // fast balls lose as little
    // clutter behind an even row, which fits neither, makes no ball of it
    const auto even = row_of({.n = 12, .interval_s = 0.9, .beat_scatter = 1e-3}, seed);
    EXPECT_LT(all_of(followed_by(even, {0.78, 0.73, 0.69, 0.37, 0.33}, 20.0)).log_odds_of_ball(), -2.0);
    // nor does a row that turns faster have lost on the whole
    const auto row = row_of({.n = 40, .interval_s = 0.5, .beat_scatter = 1e-3}, seed);
    EXPECT_LT(all_of(followed_by(row, faster_s, 100.0)).log_odds_of_ball(), -2.0);
  }
}

TEST(Hypothesis, LogOddsOfAThousandImpactsDoNotOverflow) {
  // steel on glass; 0.5 to 0.068 s
  std::vector<Candidate> ball = test::candidates_of({.eps = 0.998, .n_impacts = 1000});
  double last = 0.0;
  for (const int n : {100, 300, 1000}) {
    const Hypothesis h = all_of({ball.begin(), ball.begin() + n});
    EXPECT_EQ(h.n_impacts, n);
    EXPECT_TRUE(std::isfinite(h.log_odds_of_ball()));
    EXPECT_TRUE(std::isfinite(h.log_odds_of_rhythm()));
    EXPECT_GT(h.log_odds, last + 100.0);
    last = h.log_odds;
  }
  for (Candidate& c : ball) c.t_s = 1.0 + 0.3 * static_cast<double>(&c - ball.data());  // and of a clock
  const Hypothesis clock = all_of(ball);
  EXPECT_TRUE(std::isfinite(clock.log_odds_of_ball()));
  EXPECT_LT(clock.log_odds_of_ball(), -100.0);
}

Track track_of(const std::vector<std::size_t>& candidates) {
  Track track;
  for (const std::size_t k : candidates) track.impacts.push_back({k, std::ssize(track.impacts)});
  return track;
}

std::vector<Track> rescored_of(const std::vector<Candidate>& candidates, const std::vector<Track>& tracks) {
  return rescored(Observations(candidates, test::kTiming_s, kNone), tracks);
}

std::vector<std::size_t> from_to(std::size_t first, std::size_t last) {
  std::vector<std::size_t> all;
  for (std::size_t k = first; k <= last; ++k) all.push_back(k);
  return all;
}

TEST(Rescoring, OfTracksThatOverlapTheSurestIsKept) {
  // a drop of ten and a triple in which one of its sounds is the last
  const std::vector<Candidate> ball = test::candidates_of({});
  std::vector<Candidate> candidates = test::joined(ball, {test::candidate(0.2, 300.0)});
  const Track whole = track_of(from_to(1, 10)), triple = track_of({0, 1, 3});
  for (const std::vector<Track>& order : {std::vector<Track>{triple, whole}, {whole, triple}}) {
    const std::vector<Track> tracks = rescored_of(candidates, order);
    ASSERT_EQ(tracks.size(), 1u);
    EXPECT_EQ(tracks[0].impacts.back().candidate, 10u);
  }
}

/// Sounds enough for a track in every second of a recording.
std::vector<Candidate> sounds_of(double duration_s) {
  std::vector<Candidate> sounds;
  for (double t_s = 0.1; t_s < duration_s; t_s += 0.5) sounds.push_back({t_s, 100.0, 0.4e-3, 50.0});
  return sounds;
}

/// Log odds of one of n tracks alike.
double weighed(double log_odds, std::size_t n_tracks, double duration_s) {
  std::vector<Track> tracks(n_tracks);
  for (Track& track : tracks) track.log_odds = log_odds;
  weigh_by_drop_rate(sounds_of(duration_s), tracks);
  return tracks.front().log_odds;
}

TEST(DropRate, AChanceRowInAnHourNeedsBetterReasonsThanAClipOfOneDrop) {
  EXPECT_NEAR(weighed(2.0, 1, 3.0), 2.0, 1e-9);
  EXPECT_LT(weighed(3.0, 1, 3600.0), 0.0);
  // the rate is one in the hour at least: no track is asked for more than that
  EXPECT_GT(weighed(3.0, 1, 3600.0), 3.0 - std::log(900.0));
  double last = weighed(3.0, 1, 4.0);
  for (const double duration_s : {40.0, 400.0, 4000.0}) {
    const double now = weighed(3.0, 1, duration_s);
    EXPECT_LT(now, last);
    last = now;
  }
}

TEST(DropRate, ManyDropsSpeakForEachOther) {
  EXPECT_GT(weighed(3.0, 200, 3600.0), weighed(3.0, 20, 3600.0));
  EXPECT_GT(weighed(3.0, 20, 3600.0), weighed(3.0, 1, 3600.0));
  EXPECT_NEAR(weighed(3.0, 300, 3600.0), 3.0, 0.5);  // one in three windows: the largest rate
}

}  // namespace

}  // namespace bouncelab::detection
