// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/law_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "bouncelab/core/error.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "calibration.hpp"
#include "few_samples.hpp"
#include "support/sanitizers.hpp"
#include "support/statistics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using testing::independent_samples;
using testing::Scatter;
using testing::SyntheticRun;

/// Pulls and coverage of eps at the nodes and of the parameters over seeds.
struct Study {
  double sum = 0.0, sum2 = 0.0, in68 = 0.0, in95 = 0.0, n = 0.0;
  void add(const Estimate& e, double truth) {
    const double pull = (e.value - truth) / *e.se;
    sum += pull;
    sum2 += pull * pull;
    in68 += e.ci68->lo <= truth && truth <= e.ci68->hi;
    in95 += e.ci95->lo <= truth && truth <= e.ci95->hi;
    n += 1.0;
  }
  double mean() const { return sum / n; }
  double sd() const { return std::sqrt(sum2 / n - mean() * mean()); }
};

struct Pulls {
  Study node[3], parameter[3];
};

Pulls study(SyntheticRun run, std::size_t n, double sigma, const LawFitConfig& config, int n_seeds) {
  const double a[3] = {0.0467, 0.1339, -0.2876};
  Pulls pulls;
  for (int seed = 1; seed <= n_seeds; ++seed) {
    run.seed = static_cast<std::uint64_t>(seed);
    const auto fit = fit_law(independent_samples(run, n, 0.2, 1.4, sigma), config);
    EXPECT_NE(fit.status, FitStatus::not_converged) << seed;
    for (int j = 0; j < 3; ++j) {
      pulls.node[j].add(fit.nodes[j].eps, restitution(SeriesLaw{}, fit.nodes[j].v_mps));
      pulls.parameter[j].add(fit.parameters[j].estimate, a[j]);
    }
  }
  return pulls;
}

/// Profiles cost three times the fit and change no pull.
LawFitConfig quick() {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  return config;
}

TEST(LawFit, PullsAreThoseOfAStandardNormalWithNoiseOfTheTimesAndWithScatterThatIsNotAsModelled) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // scatter at 1 m/s 4e-4 / 3e-4: sd 5e-4; noise of 8.7e-4 doubles it; and Student's t of three in 84 drops
  const int n_seeds = test::repetitions(8, 40);
  const double error = 1.0 / std::sqrt(static_cast<double>(n_seeds));
  SyntheticRun heavy;
  heavy.scatter = Scatter::student_t3;
  for (const auto& [run, n, sigma] : {std::tuple{SyntheticRun{}, 4000u, 0.0}, std::tuple{SyntheticRun{}, 8000u, 8.7e-4},
                                      std::tuple{heavy, 8000u, 0.0}}) {
    SCOPED_TRACE(sigma);
    const bool is_as_modelled = run.scatter != Scatter::student_t3;
    const Pulls pulls = study(run, n, sigma, quick(), n_seeds);
    for (int j = 0; j < 3; ++j)
      for (const Study* s : {&pulls.node[j], &pulls.parameter[j]}) {
        // mean and standard deviation of n pulls are good to 1/sqrt(n) and 1/sqrt(2 n): three and a bit of these
        EXPECT_NEAR(s->mean(), 0.0, 3.1 * error);
        EXPECT_LT(s->sd(), 1.0 + 2.4 * error);
        EXPECT_TRUE(!is_as_modelled || s->sd() > 1.0 - 2.2 * error) << s->sd();
      }
  }
}

TEST(LawFit, ProfileIntervalsCoverAlsoWhereSamplesAreFew) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // 60 samples: the surface is far from a parabola; the smoothed kink costs some .02
  const auto pulls = study({}, 60, 0.0, {}, test::repetitions(40, 150));
  for (const Study* s : {&pulls.node[0], &pulls.node[1], &pulls.node[2], &pulls.parameter[0], &pulls.parameter[1],
                         &pulls.parameter[2]}) {
    EXPECT_GE(s->in68, test::fewest_of(s->n, 0.66));
    EXPECT_LE(s->in68, test::most_of(s->n, 0.72));
    EXPECT_GE(s->in95, test::fewest_of(s->n, 0.93));
    EXPECT_NEAR(s->mean(), 0.0, 4.5 / std::sqrt(s->n));
  }
}

TEST(LawFit, SmallSamplesAreNotCalledBadFits) {
  // p is conservative there: of right models no more than the nominal 5 % fall below .05
  const int n_seeds = test::repetitions(25, 100);
  for (const double sigma : {0.0, 1e-3}) {
    int n_low = 0;
    for (int seed = 1; seed <= n_seeds; ++seed) {
      SyntheticRun run;
      run.seed = static_cast<std::uint64_t>(seed);
      const auto fit = fit_law(independent_samples(run, 60, 0.2, 1.4, sigma), quick());
      n_low += fit.pearson && fit.pearson->p_value < 0.05;
    }
    EXPECT_LE(n_low, test::most_of(n_seeds, 0.05)) << sigma;
  }
}

TEST(LawFit, ProfileIsTheCovarianceWhereSamplesAreMany) {
  SyntheticRun run;
  const auto samples = independent_samples(run, 20000, 0.2, 1.4, 5e-4);
  const auto profile = fit_law(samples, {}), covariance = fit_law(samples, quick());
  for (int j = 0; j < 3; ++j) {
    const auto &p = profile.parameters[j].estimate, &c = covariance.parameters[j].estimate;
    ASSERT_NE(p.ci95->lo, c.ci95->lo);
    // the surface's third derivative and its grain at n = 20000: a few percent of the standard error
    EXPECT_NEAR(p.ci95->lo, c.ci95->lo, 0.15 * *c.se);
    EXPECT_NEAR(p.ci95->hi, c.ci95->hi, 0.15 * *c.se);
    EXPECT_NEAR(p.ci68->lo, c.ci68->lo, 0.15 * *c.se);
  }
}

TEST(LawFit, StatesTheCramerRaoBound) {
  // at one speed, in closed form: the information on (peak, log below, log above) inverted by hand; with equal sides b
  // the peak's variance is 2 b^2 / n, twice that of known sides
  SyntheticRun run;
  run.above_at_1mps = run.below_at_1mps = 4e-4;
  LawFitConfig config = quick();
  config.kind = LawKind::constant;
  config.n_scatter_terms = 1;
  const std::size_t n = 1200;  // enough to see that there is no normal part
  auto samples = independent_samples(run, n, 0.999, 1.001, 0.0);
  for (auto& s : samples) s.drop = 0;  // the model's errors
  const auto fit = fit_law(samples, config);
  ASSERT_EQ(fit.scatter->normal_ratio, 0.0);
  const double b = std::sqrt(fit.scatter->below(1.0) * fit.scatter->above(1.0));
  // the smoothed kink costs about 1/sqrt(n) of it
  EXPECT_NEAR(*fit.parameters[0].estimate.se_independent / (b * std::sqrt(2.0 / n)), 1.0, 0.05);
}

TEST(LawFit, FollowsThePeakNotTheMean) {
  SyntheticRun run;
  run.below_at_1mps = 6e-4;
  run.above_at_1mps = 3e-4;
  const auto peak = fit_law(independent_samples(run, 20000, 0.2, 1.4, 0.0), {});
  for (int j = 0; j < 3; ++j) {
    const double v = peak.nodes[j].v_mps, truth = restitution(SeriesLaw{}, v);
    EXPECT_LT(std::abs(peak.nodes[j].eps.value - truth), 4.0 * *peak.nodes[j].eps.se);
    // the mean lies below the peak by b_below - b_above
    EXPECT_NEAR(peak.scatter->mean_minus_peak(v), -3e-4 / v, 0.1 * 3e-4 / v);
  }
  EXPECT_GT(peak.pearson->p_value, 1e-3);
}

TEST(LawFit, ViscoelasticLawFindsGamma) {
  SyntheticRun run;
  run.law = ViscoelasticLaw{0.02};
  LawFitConfig config;
  config.kind = LawKind::viscoelastic;
  const auto fit = fit_law(independent_samples(run, 5000, 0.2, 1.4, 2e-4), config);
  ASSERT_EQ(fit.status, FitStatus::ok);
  const auto& gamma = fit.parameters.at(0);
  EXPECT_EQ(gamma.name, "gamma");
  EXPECT_LT(std::abs(gamma.estimate.value - 0.02), 4.0 * *gamma.estimate.se);
  EXPECT_LT(*gamma.estimate.se, 1e-4);
}

TEST(LawFit, OnOneShortDropSaysThatAIsNotIdentifiableAndItsIntervalsCover) {
  // a ping-pong ball: 50 impacts, eps .946, times good to 0.1 ms, noise and scatter alike in size. Not bounded above:
  // errors of neighbouring times compensate, which the likelihood does not know
  double in95 = 0.0, in68 = 0.0, n = 0.0;
  for (int seed = 1; seed <= test::repetitions(12, 60); ++seed) {
    SyntheticRun run;
    run.n_drops = 1;
    run.n_impacts = 50;
    run.law = ConstantLaw{0.946};
    run.below_at_1mps = run.above_at_1mps = 2e-3;
    run.timing_sigma_s = 1e-4;
    run.seed = static_cast<std::uint64_t>(seed);
    const auto fit = fit_law(restitution_samples(synthetic_onsets(run), {}).samples, {});
    EXPECT_EQ(fit.status, FitStatus::not_identifiable);
    ASSERT_TRUE(fit.why);
    EXPECT_EQ(fit.why->kind, NoteKind::not_identifiable);
    EXPECT_EQ(fit.why->subject.find("A2 "), 0u) << fit.why->subject;
    for (const auto& p : fit.parameters) EXPECT_FALSE(p.estimate.identified);
    ASSERT_EQ(fit.nodes.size(), 3u);
    const Estimate& eps = fit.nodes[1].eps;
    in95 += eps.ci95->lo <= 0.946 && 0.946 <= eps.ci95->hi;
    in68 += eps.ci68->lo <= 0.946 && 0.946 <= eps.ci68->hi;
    n += 1.0;
  }
  EXPECT_GE(in95, test::fewest_of(n, 0.95));
  EXPECT_GE(in68, test::fewest_of(n, 0.68));
}

TEST(LawFit, OfFewBouncesOfManyDropsOfARoughBallIsThatOfSmoothContact) {
  // first bounces only lose: a scatter by speed alone held the law in three of ten seeds
  for (const double v_lo_mps : {1.25, 1.1}) {
    CalibrationConfig config;
    config.v_lo_mps = v_lo_mps;
    config.n_samples = 150;
    double in95 = 0.0, n = 0.0;
    for (int seed = 0; seed < test::repetitions(30, 200); ++seed) {
      const auto fit = fit_law(calibration_samples(config, static_cast<std::uint64_t>(seed)), quick());
      ASSERT_FALSE(fit.nodes.empty()) << seed;
      const auto& node = fit.nodes[fit.nodes.size() / 2];
      const double truth = restitution(SeriesLaw{}, node.v_mps);
      in95 += node.eps.ci95->lo <= truth && truth <= node.eps.ci95->hi;
      n += 1.0;
    }
    EXPECT_GE(in95, test::fewest_of(n, 0.95)) << "down to " << v_lo_mps << " m/s, of " << n;
  }
}

TEST(LawFit, OfScatterByChanceIsNotTakenForThatOfARoughBall) {
  // without impacts' places a law of the same samples must be the same, but where chance looks like a rough ball
  double alike = 0.0, n = 0.0;
  for (int seed = 1; seed <= test::repetitions(20, 100); ++seed) {
    SyntheticRun run;
    run.seed = static_cast<std::uint64_t>(seed);
    RestitutionSamples samples = independent_samples(run, 80, 1.1, 1.4, 0.0);
    for (std::size_t k = 0; k < samples.size(); ++k) samples[k].impact = static_cast<std::int64_t>(1 + k % 8);
    const auto numbered = fit_law(samples, quick());
    for (auto& s : samples) s.impact = 1000;
    alike += fit_law(samples, quick()).nodes[0].eps.value == numbered.nodes[0].eps.value;
    n += 1.0;
  }
  EXPECT_GE(alike, test::fewest_of(n, 0.95));
}

TEST(LawFit, NodesFollowTheSpeedsOfTheSamplesAndHaveTwoDigits) {
  // speeds even in log v: 10, 50 and 90 % of them lie below lo (hi/lo)^.1, .5, .9, to .02 in log v with 500 samples
  // (three standard errors), and two digits move a node by 0.05
  for (const auto& [lo, hi] : {std::pair{0.2, 4.0}, std::pair{0.02, 0.3}, std::pair{30.0, 45.0}}) {
    RestitutionSamples samples = independent_samples({}, 500, 0.2, 1.4, 1e-4);
    for (std::size_t k = 0; k < samples.size(); ++k)
      samples[k].v_mps = lo * std::pow(hi / lo, (static_cast<double>(k) + 0.5) / 500.0);
    const LawFit fit = fit_law(samples, {});
    ASSERT_EQ(fit.nodes.size(), 3u);
    for (std::size_t j = 0; j < 3; ++j) {
      const double v_mps = fit.nodes[j].v_mps, share = 0.1 + 0.4 * static_cast<double>(j);
      EXPECT_NEAR(std::log(v_mps), std::log(lo * std::pow(hi / lo, share)), 0.07);
      char two_digits[32];
      std::snprintf(two_digits, sizeof two_digits, "%.2g", v_mps);
      EXPECT_EQ(std::stod(two_digits), v_mps);
    }
  }
  // of nearly one speed they stay apart and within it
  RestitutionSamples samples = independent_samples({}, 500, 0.2, 1.4, 1e-4);
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].v_mps = 0.5 + 1e-5 * static_cast<double>(k);
  const LawFit fit = fit_law(samples, {});
  ASSERT_EQ(fit.nodes.size(), 3u);
  EXPECT_TRUE(0.5 <= fit.nodes[0].v_mps && fit.nodes[0].v_mps < fit.nodes[1].v_mps &&
              fit.nodes[1].v_mps < fit.nodes[2].v_mps && fit.nodes[2].v_mps <= 0.505);
}

TEST(LawFit, DoesNotChangeWithTheOrderOfSamples) {
  auto samples = independent_samples({}, 2000, 0.2, 1.4, 2e-4);
  const auto fit = fit_law(samples, {});
  std::reverse(samples.begin(), samples.end());
  const auto again = fit_law(samples, {});
  EXPECT_EQ(fit.parameters[0].estimate.value, again.parameters[0].estimate.value);
}

TEST(LawFit, OfFewSamplesGivesTheLawTheyCanTell) {
  for (const std::size_t n : {3u, 4u, 5u, 7u, 8u}) {
    const auto fit = fit_law(testing::few_samples(testing::FewScatter::normal, n, 1), {});
    ASSERT_NE(fit.status, FitStatus::too_few_samples) << n;
    EXPECT_EQ(fit.kind, n < 5 ? LawKind::constant : LawKind::series);
    EXPECT_EQ(fit.parameters.size(), n < 5 ? 1u : n < 8 ? 2u : 3u);
    EXPECT_EQ(fit.notes.empty(), n >= 8) << n;
    for (const NodeEstimate& node : fit.nodes) {
      ASSERT_TRUE(node.eps.ci95) << n;
      EXPECT_LT(node.eps.ci95->lo, node.eps.value);
      EXPECT_GT(node.eps.ci95->hi, node.eps.value);
    }
  }
}

TEST(LawFit, IntervalsOfFewSamplesCoverWhateverTheScatter) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // the short version of tests/bench/few_samples_coverage; three speeds, whose errors go together by a half
  const std::vector<double> speeds_mps{0.12, 0.3, 0.7};
  const auto n_seeds = test::repetitions<std::uint64_t>(12, 40);
  for (const std::size_t n : {8u, 40u})
    for (const testing::FewScatter scatter :
         {testing::FewScatter::normal, testing::FewScatter::laplace, testing::FewScatter::asymmetric,
          testing::FewScatter::student_t3, testing::FewScatter::one_lost}) {
      Study at[3];
      for (std::uint64_t seed = 1; seed <= n_seeds; ++seed) {
        LawFitConfig config;
        config.node_speeds_mps = speeds_mps;
        const auto fit = fit_law(testing::few_samples(scatter, n, seed), config);
        ASSERT_EQ(fit.nodes.size(), 3u);
        for (std::size_t j = 0; j < 3; ++j) at[j].add(fit.nodes[j].eps, testing::few_samples_eps(speeds_mps[j]));
      }
      const double in95 = (at[0].in95 + at[1].in95 + at[2].in95) / 2.0;
      EXPECT_GE(in95, test::fewest_of(1.5 * static_cast<double>(n_seeds), 0.95))
          << n << " " << testing::to_string(scatter);
      if (n >= 40) {
        EXPECT_NEAR((at[0].sd() + at[1].sd() + at[2].sd()) / 3.0, 1.0, 1.8 / std::sqrt(static_cast<double>(n_seeds)))
            << testing::to_string(scatter);
      }
    }
}

TEST(LawFit, OneLostBounceInFortyMovesTheCurveByLessThanAFifthOfItsError) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    RestitutionSamples samples = testing::few_samples(testing::FewScatter::normal, 40, seed);
    const auto before = fit_law(samples, {});
    RestitutionSample lost = samples[(7 * seed) % 40];
    lost.eps = 0.5 * lost.eps;
    samples.push_back(lost);
    const auto after = fit_law(samples, {});
    EXPECT_EQ(after.outliers, std::vector<std::size_t>{40});
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_LT(std::abs(after.nodes[j].eps.value - before.nodes[j].eps.value), 0.2 * *before.nodes[j].eps.se);
  }
}

TEST(LawFit, DropsTheNormalPartWhereManySamplesDoNotAskForIt) {
  // from 1,000 samples on by BIC: of two exponentials the kink is worth more than a rounded peak
  const auto exponentials = fit_law(independent_samples({}, 4000, 0.2, 1.4, 0.0), quick());
  EXPECT_EQ(exponentials.scatter->normal_ratio, 0.0);
  SyntheticRun run;
  run.scatter = Scatter::normal;
  const auto normal = fit_law(independent_samples(run, 4000, 0.2, 1.4, 0.0), quick());
  EXPECT_GT(normal.scatter->normal_ratio, 1.0);
}

TEST(LawFit, AtOneSpeedIsOneEpsAtThatSpeed) {
  const auto fit = fit_law(independent_samples({}, 200, 0.5, 0.5000001, 0.0), {});
  EXPECT_EQ(fit.status, FitStatus::ok);
  EXPECT_EQ(fit.kind, LawKind::constant);
  ASSERT_EQ(fit.parameters.size(), 1u);
  EXPECT_EQ(fit.parameters[0].name, "eps");
}

TEST(LawFit, OfIdenticalSamplesDoesNotFail) {
  auto samples = independent_samples({}, 100, 0.2, 1.4, 0.0);
  for (auto& s : samples) s.eps = 0.9;
  LawFitConfig config;
  config.kind = LawKind::constant;
  const auto fit = fit_law(samples, config);
  for (const auto& node : fit.nodes) EXPECT_NEAR(node.eps.value, 0.9, 1e-6) << to_string(fit.status);
}

TEST(LawFit, OfSamplesWithoutScatterIsExact) {
  SyntheticRun run;
  run.below_at_1mps = run.above_at_1mps = 1e-12;
  const auto fit = fit_law(independent_samples(run, 500, 0.2, 1.4, 0.0), {});
  // the resolution of eps assumed, 1e-8, over the square root of n, times the condition of A: a few 1e-7
  EXPECT_NEAR(fit.parameters.at(0).estimate.value, 0.0467, 1e-6);
  EXPECT_NEAR(fit.parameters.at(1).estimate.value, 0.1339, 4e-6);
  EXPECT_NEAR(fit.parameters.at(2).estimate.value, -0.2876, 8e-6);
}

TEST(LawFit, AboveOneIsNoViscoelasticSphere) {
  auto samples = independent_samples({}, 100, 0.2, 1.4, 0.0);
  for (auto& s : samples) s.eps += 0.2;
  LawFitConfig config;
  config.kind = LawKind::viscoelastic;
  EXPECT_EQ(fit_law(samples, config).status, FitStatus::not_applicable);
  EXPECT_GT(fit_law(samples, {}).nodes.at(0).eps.value, 1.1);
}

TEST(LawFit, RejectsBrokenContracts) {
  auto samples = independent_samples({}, 100, 0.2, 1.4, 0.0);
  LawFitConfig config;
  config.orders = {2, 3};
  EXPECT_THROW(fit_law(samples, config), InvalidArgument);
  config.orders = {2, 2};
  EXPECT_THROW(fit_law(samples, config), InvalidArgument);
  samples[5].v_mps = 0.0;
  EXPECT_THROW(fit_law(samples, {}), InvalidArgument);
}

TEST(LawFit, ASearchOfEightSamplesThatEndsBesideThemKeepsEnoughForALaw) {
  testing::SyntheticRun run;
  run.seed = 556;  // the search goes astray there
  run.below_at_1mps = 6e-3;
  run.above_at_1mps = 2e-3;
  const LawFit fit = fit_law(testing::independent_samples(run, 8, 0.2, 1.4, 2e-4), {});
  EXPECT_EQ(fit.n + fit.outliers.size(), 8u);
  EXPECT_GE(fit.n, 3u);
}

}  // namespace
}  // namespace bouncelab::fit
