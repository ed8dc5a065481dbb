// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/recordings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/fit.hpp"
#include "support/statistics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

/// One ball's recording.
struct HeardBall {
  std::string recording;
  std::size_t n = 40;
  double shift = 0.0;  ///< of eps from the common law
  std::size_t n_drops = 1;
  double sd_between_drops = 0.0;
};

RestitutionSamples samples_of(const std::vector<HeardBall>& balls, std::uint64_t seed) {
  RestitutionSamples all;
  for (std::size_t k = 0; k < balls.size(); ++k) {
    const HeardBall& ball = balls[k];
    testing::SyntheticRun run;
    run.scatter = testing::Scatter::normal;
    run.above_at_1mps = 2e-3;
    run.seed = 1000 * seed + k;
    RestitutionSamples samples = testing::independent_samples(run, ball.n, 0.2, 1.4, 1e-4);
    Random random(run.seed, RandomStream::test, 1);
    std::vector<double> of_drop;
    for (std::size_t d = 0; d < ball.n_drops; ++d) of_drop.push_back(ball.sd_between_drops * random.normal());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const std::size_t drop = i * ball.n_drops / samples.size();
      samples[i].recording = ball.recording;
      samples[i].drop = static_cast<std::int64_t>(drop);
      samples[i].eps += ball.shift + of_drop[drop];
    }
    all.insert(all.end(), samples.begin(), samples.end());
  }
  return all;
}

Recordings compared(const RestitutionSamples& samples) {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  return compare_recordings(samples, config, fit_law(samples, config));
}

/// Kolmogorov's distance of the p-values of so many experiments from the uniform distribution, over its scale.
double distance_from_uniform(const std::vector<HeardBall>& balls, std::size_t n_experiments) {
  std::vector<double> p;
  for (std::uint64_t seed = 1; seed <= n_experiments; ++seed)
    p.push_back(compared(samples_of(balls, seed)).test->p_value);
  std::sort(p.begin(), p.end());
  double distance = 0.0;
  const auto n = static_cast<double>(p.size());
  for (std::size_t k = 0; k < p.size(); ++k)
    distance = std::max({distance, (static_cast<double>(k) + 1.0) / n - p[k], p[k] - static_cast<double>(k) / n});
  return distance * std::sqrt(n);
}

TEST(Recordings, OfEqualBallsAgreeWithAUniformP) {
  const double sd = 2e-3;  // between drops, as the scatter of the samples
  const std::vector<HeardBall> whose_drops_differ{{"a", 48, 0.0, 6, sd}, {"b", 48, 0.0, 6, sd}};
  for (const auto& balls :
       {std::vector<HeardBall>{{"a"}, {"b"}}, {{"a", 8}, {"b", 8}, {"c", 8}, {"d", 8}, {"e", 8}}, whose_drops_differ})
    // Kolmogorov's distribution: once in a thousand; of so few a little less
    EXPECT_LT(distance_from_uniform(balls, test::repetitions<std::size_t>(10, 30)), 1.95) << balls.size();
  EXPECT_EQ(compared(samples_of(whose_drops_differ, 1)).test->within, WithinUnit::drops);
}

TEST(Recordings, OfTwoBallsThatDifferByAHundredthAreToldApart) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Recordings found = compared(samples_of({{"a"}, {"b", 40, 0.01}}, seed));
    EXPECT_LT(found.test->p_value, 1e-4) << seed;
    ASSERT_TRUE(found.rows.at(0).offset && found.rows.at(1).offset);
    EXPECT_NEAR(found.rows[1].offset->value - found.rows[0].offset->value, 0.01, 4e-3) << seed;
    EXPECT_TRUE(disagree(found));
  }
}

TEST(Recordings, RowsAreTheAnswersOfEachRecordingAndOfEachPlateAlone) {
  const RestitutionSamples all = samples_of({{"a", 60}, {"b", 60}, {"c", 60, 0.01}}, 8);
  const auto of = [&](std::string_view names) {
    RestitutionSamples some = all;
    std::erase_if(some, [&](const RestitutionSample& s) { return names.find(s.recording) == std::string_view::npos; });
    return some;
  };
  FitConfig config;
  config.n_goodness = 0;
  const auto expect_rows = [&](const std::vector<std::pair<std::string, std::string_view>>& rows) {
    const FitResult together = fit_all(all, config);
    ASSERT_EQ(together.recordings.rows.size(), rows.size());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const RecordingFit& row = together.recordings.rows[r];
      EXPECT_EQ(row.recording, rows[r].first);
      FitConfig alone = config;
      alone.plates.clear();
      for (const CurveNode& node : row.nodes) alone.law.node_speeds_mps.push_back(node.v_mps);
      const FitResult one = fit_all(of(rows[r].second), alone);
      ASSERT_EQ(row.nodes.size(), 3U);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(row.nodes[k].eps.value, one.curve->nodes[k].eps.value);
        EXPECT_EQ(row.nodes[k].eps.ci95->lo, one.curve->nodes[k].eps.ci95->lo);
        EXPECT_TRUE(row.nodes[k].peak);
      }
      if (config.plates.empty()) continue;
      ASSERT_EQ(row.parameters.size(), one.constants.parameters.size());
      EXPECT_EQ(row.parameters.at(0).estimate.value, one.constants.parameters.at(0).estimate.value);
    }
  };
  expect_rows({{"a", "a"}, {"b", "b"}, {"c", "c"}});
  config.plates = {{"a", "glass"}, {"b", "glass"}};
  expect_rows({{"glass", "ab"}, {"c", "c"}});
}

TEST(Recordings, OfOneOrOfTwoSamplesAreNotCompared) {
  const Recordings one = compared(samples_of({{"a"}}, 1)), few = compared(samples_of({{"a"}, {"b", 2}}, 1));
  EXPECT_FALSE(one.test || few.test);
  EXPECT_TRUE(one.rows.empty());
  ASSERT_EQ(few.rows.size(), 2u);
  EXPECT_EQ(few.rows[1].law.status, FitStatus::too_few_samples);
}

TEST(Recordings, ResultDoesNotDependOnTheirOrder) {
  RestitutionSamples samples = samples_of({{"a"}, {"b", 40, 0.002}, {"c", 30}}, 5);
  const double p = compared(samples).test->p_value;
  std::reverse(samples.begin(), samples.end());
  EXPECT_NEAR(compared(samples).test->p_value, p, 0.02 * p);  // likelihoods within 1e-3 or so of their maxima
}

TEST(Recordings, AtSpeedsOfTheirOwnCannotBeToldFromTheCurve) {
  RestitutionSamples samples = samples_of({{"a"}, {"b"}}, 5);
  for (RestitutionSample& s : samples) s.v_mps = s.recording == "a" ? 0.3 : 0.9;
  EXPECT_FALSE(compared(samples).test);
}

/// Two balls, ten drops of twelve bounces each, in one recording.
RestitutionSamples of_two_balls(double shift, double sd_between_drops, std::uint64_t seed) {
  RestitutionSamples samples =
      samples_of({{"a", 120, 0.0, 10, sd_between_drops}, {"b", 120, shift, 10, sd_between_drops}}, seed);
  for (RestitutionSample& s : samples) {
    if (s.recording == "b") s.drop += 10;
    s.recording.clear();
  }
  return samples;
}

TEST(KindsOfDrops, AreTwoWhereThereAreTwoBallsAndNotWhereDropsOfOneDiffer) {
  for (std::uint64_t seed = 1; seed <= test::repetitions<std::uint64_t>(10, 30); ++seed) {
    // single impacts scatter by some .004
    const auto two = two_kinds_of_drops(of_two_balls(-0.05, 2e-3, seed));
    ASSERT_TRUE(two) << seed;
    EXPECT_EQ(two->n_lower, 10u);
    EXPECT_EQ(two->n_upper, 10u);
    EXPECT_NEAR(two->eps_upper - two->eps_lower, 0.05, 5e-3);
    for (const double sd : {0.0, 2e-3, 1e-2}) EXPECT_FALSE(two_kinds_of_drops(of_two_balls(0.0, sd, seed))) << seed;
  }
}

/// Two drops in one sound.
RestitutionSamples of_two_drops(std::size_t n_bounces, double sd, double other, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 4);
  RestitutionSamples samples;
  for (const double eps : {0.85, other}) {
    double v_mps = 2.0;
    for (std::size_t k = 0; k < n_bounces; ++k) {
      RestitutionSample s;
      s.drop = static_cast<std::int64_t>(samples.size() / n_bounces);
      s.impact = static_cast<std::int64_t>(k);
      s.v_mps = v_mps;
      s.eps = eps + sd * random.normal();
      v_mps *= s.eps;
      samples.push_back(s);
    }
  }
  return samples;
}

TEST(KindsOfDrops, AreTwoOfTwoSingleDropsOfTwoBallsAndOneOfOneBall) {
  std::size_t n_false = 0;
  const auto n = test::repetitions<std::size_t>(200, 2000);
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const auto two = two_kinds_of_drops(of_two_drops(5, 4e-3, 0.65, seed));
    ASSERT_TRUE(two) << seed;
    EXPECT_NEAR(two->eps_upper - two->eps_lower, 0.2, 0.02);
    for (const double sd : {4e-3, 3e-2}) n_false += two_kinds_of_drops(of_two_drops(5, sd, 0.85, seed)) ? 1 : 0;
  }
  EXPECT_LE(n_false, test::most_of(2.0 * static_cast<double>(n), 0.01));
}

TEST(KindsOfDrops, OneBallFromTwoHeightsIsOfOneKindThoughNothingScatters) {
  for (const double other_mps : {2.0, 10.0}) {
    RestitutionSamples samples;
    for (int drop = 0; drop < 10; ++drop) {
      double v_mps = (drop < 5 ? 1.0 : other_mps) * (1.0 + 0.01 * drop);
      for (int k = 0; k < 4; ++k) {
        RestitutionSample s;
        s.drop = drop;
        s.impact = k;
        s.v_mps = v_mps;
        s.eps = 1.0 - 0.2 * std::pow(v_mps, 0.2);
        v_mps *= s.eps;
        samples.push_back(s);
      }
    }
    EXPECT_FALSE(two_kinds_of_drops(samples)) << other_mps;
  }
}

TEST(RepeatedDrops, AreThoseThatAreCopiesAndNoOthers) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    bouncelab::testing::SyntheticRun run;
    run.n_drops = 60;
    run.n_impacts = 8 + 10 * static_cast<std::size_t>(seed % 3);
    run.timing_sigma_s = 3e-6;
    run.seed = seed;
    RestitutionSamples samples = restitution_samples(bouncelab::testing::synthetic_onsets(run), {}).samples;
    EXPECT_TRUE(repeated_drops(samples).empty()) << seed;
    // a copy whose beginning was cut off, at another rate: times are off by some us
    Random random(seed, RandomStream::test, 2);
    RestitutionSamples copy;
    for (const RestitutionSample& s : samples)
      if (s.drop == 7 && s.impact > 1) copy.push_back(s);
    for (RestitutionSample& s : copy) {
      s.recording = "copy.mp3";
      s.drop = 0;
      s.eps += 1e-6 * random.normal();
    }
    samples.insert(samples.end(), copy.begin(), copy.end());
    const auto repeated = repeated_drops(samples);
    ASSERT_EQ(repeated.size(), 1u) << seed;
    EXPECT_EQ(repeated[0].recording, "copy.mp3");
    EXPECT_EQ(repeated[0].of_drop, 7);
  }
}

/// Drops of one ball of constant eps from 5 cm and 1 m, as a watch that shows so many seconds has their times.
RestitutionSamples from_two_heights(std::size_t n_drops, int n_bounces, double watch_s, bool two_only,
                                    std::uint64_t seed) {
  Random random(seed, RandomStream::test, 3);
  Onsets onsets;
  for (std::size_t drop = 0; drop < n_drops; ++drop) {
    double v_mps = std::sqrt(2.0 * 9.81 * (two_only && drop % 2 == 0 ? 0.05 : 1.0)), t_s = 0.5;
    for (int k = 0; k <= n_bounces; ++k) {
      Onset onset;
      onset.drop = static_cast<std::int64_t>(drop);
      onset.impact = k;
      onset.t_s = watch_s > 0.0 ? watch_s * std::round(t_s / watch_s) : t_s;
      if (watch_s > 0.0) onset.sigma_t_s = watch_s / std::sqrt(12.0);
      onsets.push_back(onset);
      v_mps *= 0.93 + 2e-3 * random.normal();
      t_s += 2.0 * v_mps / 9.81;
    }
  }
  return restitution_samples(onsets, {}).samples;
}

TEST(KindsOfDrops, AreNotTwoOfOneBallFromTwoHeightsWhoseSlopeIsHardlyKnown) {
  int n_false = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const RestitutionSamples samples = from_two_heights(4 + 2 * (seed % 2), 5, 0.0, true, seed);
    n_false += two_kinds_of_drops(samples) ? 1 : 0;
  }
  EXPECT_LE(n_false, 2);
}

TEST(RepeatedDrops, AreNotThoseOfAWatchThatShowsHundredths) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    EXPECT_TRUE(repeated_drops(from_two_heights(6, 6, 0.01, false, seed)).empty()) << seed;
}

}  // namespace
}  // namespace bouncelab::fit
