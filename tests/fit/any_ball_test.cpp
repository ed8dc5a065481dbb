// SPDX-License-Identifier: GPL-3.0-or-later
// Balls that people drop, in air and with contacts that last, from an integrator of its own: does the 95 % interval of
// eps hold the truth, whether the ball is named or not?
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "drawn_balls.hpp"
#include "support/statistics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kG = 9.81;

struct Kind {
  std::string name;  ///< to the program
  double radius_m, mass_kg;
  double tau_lo_s, tau_hi_s, exponent;
  double eps_lo, eps_hi;
  double drag_factor_hi;  ///< felt, seams
};

const std::vector<Kind> kKinds{{"table-tennis", 0.020, 2.7e-3, 0.6e-3, 1.0e-3, 0.0, 0.85, 0.93, 1.1},
                               {"golf", 0.021335, 45.93e-3, 0.42e-3, 0.6e-3, -0.2, 0.75, 0.88, 1.1},
                               {"steel:10mm", 0.005, 4.136e-3, 0.0, 0.0, -0.2, 0.85, 0.97, 1.05},
                               {"glass:16mm", 0.008, 5.362e-3, 0.0, 0.0, -0.2, 0.80, 0.96, 1.05},
                               {"tennis", 0.0335, 57.7e-3, 4e-3, 6e-3, -0.1, 0.68, 0.80, 1.25},
                               {"basketball", 0.121, 0.600, 10e-3, 18e-3, 0.0, 0.72, 0.86, 1.1},
                               {"superball:27mm", 0.0135, 11.3e-3, 2e-3, 4e-3, -0.1, 0.82, 0.92, 1.05},
                               {"squash", 0.020, 24e-3, 2.3e-3, 3.8e-3, 0.0, 0.40, 0.60, 1.05}};

struct World {
  Kind kind;
  double drag_factor, tau_1_s;
  double eps_1, slope;  ///< eps = eps_1 + slope ln v
  double scatter, sigma_t_s;
  double step = 0.0, step_mps = 0.0;  ///< of those slower than that
  double yield_mps = 0.0;             ///< above it eps is that of an elastic, perfectly plastic contact instead
};

double truth(const World& w, double v) {
  if (w.yield_mps > 0.0) return bouncelab::testing::eps_by_thornton(v, w.yield_mps);
  return w.eps_1 + w.slope * std::log(v) + (v < w.step_mps ? w.step : 0.0);
}

/// As eps is stated: the root mean square over bounces.
double stated_truth(const World& w, double v) { return std::hypot(truth(w, v), w.scatter); }

bouncelab::testing::IntegratedFlight flight(const World& w, double u) {
  return bouncelab::testing::flight_in_air(w.kind.radius_m, w.kind.mass_kg, w.drag_factor, u, 1000);
}

World drawn(const Kind& kind, Random& random) {
  const auto between = [&](double lo, double hi) { return lo + (hi - lo) * random.uniform(); };
  World w{kind,
          between(0.95, kind.drag_factor_hi),
          between(kind.tau_lo_s, kind.tau_hi_s),
          between(kind.eps_lo, kind.eps_hi),
          0.0,
          0.0,
          0.0};
  // Hertz's contact of the massive ones, on glass: half of 100 us each way is no matter here
  if (w.tau_1_s == 0.0) w.tau_1_s = (kind.radius_m < 0.006 ? 30e-6 : 48e-6) * between(0.9, 1.1);
  w.slope = random.uniform() < 0.3 ? 0.0 : -between(0.0, 0.03);
  w.scatter = between(0.0005, 0.004) * (1.0 - w.eps_1) / 0.15;
  w.sigma_t_s = between(5e-6, 60e-6);
  return w;
}

Onsets heard(const World& w, Random& random, std::int64_t drop = 0) {
  Onsets onsets;
  const double h = 0.15 + 0.85 * random.uniform();
  double v = flight(w, std::sqrt(2.0 * kG * h)).landing_mps, t = 1.0;
  const double least_mps = 0.12 + 0.2 * random.uniform();
  for (int k = 0; k < 40; ++k) {
    Onset onset;
    onset.recording = "a";
    onset.drop = drop;
    onset.impact = k;
    onset.t_s = t + w.sigma_t_s * random.normal();
    onset.sigma_t_s = w.sigma_t_s;
    onsets.push_back(onset);
    const double tau = w.tau_1_s * std::pow(v, w.kind.exponent);
    const double u = v * (truth(w, v) + w.scatter * random.normal());
    const auto [duration_s, landing_mps] = flight(w, u);
    t += tau + duration_s;
    v = landing_mps;
    if (v < least_mps || duration_s < 4.0 * tau) break;
  }
  return onsets;
}

TEST(AnyBall, OfManyDropsIsNotTakenForWhatMakesTheScatterLook) {
  // a deviation that shrinks each sample's own scatter, and a scatter that is held to what it is of another ball, made
  // this a basketball: 0.016 too low in eps, 30 standard errors
  World w{kKinds[2], 1.0, 37e-6, 0.97, -0.01, 0.001, 1e-6};
  for (const std::uint64_t seed : {1, 2}) {
    Random random(seed, RandomStream::test, 0);
    Onsets onsets;
    for (std::int64_t drop = 0; drop < 20; ++drop)
      for (const Onset& onset : heard(w, random, drop)) onsets.push_back(onset);
    FitConfig fit;
    fit.n_goodness = 0;
    const FitResult result = fit_all(restitution_samples(onsets, {}).samples, fit);
    ASSERT_TRUE(result.curve);
    for (const CurveNode& node : result.curve->nodes) {
      const double t = stated_truth(w, node.v_mps);
      EXPECT_LE(node.eps.ci95->lo, t) << seed << " " << node.v_mps;
      EXPECT_GE(node.eps.ci95->hi, t) << seed << " " << node.v_mps;
    }
  }
}

class AnyBallNamed : public ::testing::TestWithParam<bool> {};

TEST_P(AnyBallNamed, HasItsTrueRestitutionInTheInterval) {
  double n = 0.0, n_held = 0.0, pulls2 = 0.0;
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind)
    for (int run = 0; run < test::repetitions(2, 40); ++run) {
      Random random(77 + kind, RandomStream::test, static_cast<std::uint64_t>(run));
      const World w = drawn(kKinds[kind], random);
      const Onsets onsets = heard(w, random);
      RestitutionConfig config;
      if (GetParam()) config.ball = ball_from_text(w.kind.name), config.plate = kGlass;
      FitConfig fit;
      fit.n_goodness = 0;
      const FitResult result = fit_all(restitution_samples(onsets, config).samples, fit);
      ASSERT_TRUE(result.curve) << w.kind.name << " " << run;
      const CurveNode& node = result.curve->nodes[result.curve->nodes.size() / 2];
      const double t = stated_truth(w, node.v_mps), pull = (node.eps.value - t) / *node.eps.se;
      n += 1.0;
      n_held += t >= node.eps.ci95->lo && t <= node.eps.ci95->hi;
      pulls2 += pull * pull;
    }
  std::cout << n_held << " of " << n << ", pulls " << std::sqrt(pulls2 / n) << "\n";
  // nine in ten, where contacts of milliseconds make nearly the same intervals as a slope
  EXPECT_GE(n_held, test::fewest_of(n, 0.9));
  // pulls of a standard normal have squares of mean 1 and variance 2, those of Student's t, of few impacts, somewhat
  // more: a standard error that is half the true one is seen in 16
  EXPECT_LT(pulls2 / n, 1.5 + 3.0 * std::sqrt(2.0 / n));
}
INSTANTIATE_TEST_SUITE_P(AnyBall, AnyBallNamed, ::testing::Bool(),
                         [](const auto& of) { return of.param ? "named" : "not_named"; });

TEST(AnyBall, OfManyDropsOfASimulationHasItsTrueRestitutionInTheInterval) {
  bouncelab::testing::SyntheticRun run;
  run.n_drops = test::repetitions<std::size_t>(6, 60);
  FitConfig config;
  config.memory = UseMemory::never;
  config.n_goodness = 0;
  const FitResult result = fit_all(restitution_samples(bouncelab::testing::synthetic_onsets(run), {}).samples, config);
  ASSERT_TRUE(result.curve);
  // made without contact time or air: what there is of either is not told from none, and eps is right
  ASSERT_TRUE(result.curve->contact_s);
  EXPECT_LT(result.curve->contact_s->ci95->lo, 1e-4);
  for (const CurveNode& node : result.curve->nodes) {
    const double below = mean_below(run, node.v_mps), above = mean_above(run, node.v_mps);
    const double t = std::hypot(restitution(run.law, node.v_mps) + above - below, std::hypot(below, above));
    // no air is the edge of what may be beforehand
    const double beside = 0.1 * (node.eps.ci95->hi - node.eps.ci95->lo);
    EXPECT_LE(node.eps.ci95->lo - beside, t) << node.v_mps;
    EXPECT_GE(node.eps.ci95->hi + beside, t) << node.v_mps;
  }
}

/// Steel on a plate that yields, by people who name neither: contacts of milliseconds of a ball without slope make
/// nearly the same intervals.
TEST(AnyBall, ThatYieldsHasItsTrueRestitutionInTheInterval) {
  const int n_runs = test::repetitions(3, 20);
  double pulls2 = 0.0;
  for (int run = 0; run < n_runs; ++run) {
    Random random(6, RandomStream::test, static_cast<std::uint64_t>(run));
    World w = drawn(kKinds[2], random);
    w.scatter = 0.004, w.yield_mps = 0.04 + 0.1 * random.uniform();  // eps of 0.6 to 0.8 at 1 m/s
    Onsets onsets;
    for (int drop = 0; drop < 3; ++drop)
      for (Onset& onset : heard(w, random)) {
        onset.drop = drop;
        onsets.push_back(std::move(onset));
      }
    FitConfig fit;
    fit.n_goodness = 0;
    const FitResult result = fit_all(restitution_samples(onsets, {}).samples, fit);
    ASSERT_TRUE(result.curve);
    const CurveNode& node = result.curve->nodes[result.curve->nodes.size() / 2];
    const double t = stated_truth(w, node.v_mps);
    const double pull = (node.eps.value - t) / *node.eps.se;
    pulls2 += pull * pull;
  }
  // contacts of no time are the edge of what may be beforehand, so that the truth is often at an interval's end; those
  // taken for long ones are off by six standard errors
  EXPECT_LT(std::sqrt(pulls2 / n_runs), 2.0);
}

/// As somebody found of a table-tennis ball that rolled from wood to a carpet's edge: the law with a step is right, and
/// without one none is claimed.
TEST(AnyBall, ThatMeetsAnotherSurfaceIsSaidToDoSo) {
  for (int run = 0; run < test::repetitions(2, 12); ++run) {
    Random random(5, RandomStream::test, static_cast<std::uint64_t>(run));
    World w = drawn(kKinds[0], random);
    w.eps_1 = 0.92, w.slope = 0.0, w.scatter = 0.003, w.step_mps = 0.68;
    w.step = run % 2 == 0 ? -0.07 : 0.0;
    FitConfig fit;
    fit.n_goodness = 0;
    RestitutionConfig named;
    named.ball = ball_from_text(w.kind.name);
    const RestitutionSamples samples = restitution_samples(heard(w, random), named).samples;
    const FitResult result = fit_all(samples, fit);
    ASSERT_TRUE(result.curve);
    EXPECT_EQ(result.curve->step.has_value(), w.step != 0.0) << run;
    if (!result.curve->step) continue;
    // two or three impacts lie within a fifth of a speed; four standard errors of the means of ten
    EXPECT_NEAR(result.curve->step->v_mps / w.step_mps, 1.0, 0.1);
    EXPECT_NEAR(result.curve->step->eps_faster, 0.92, 4.0 * w.scatter / std::sqrt(10.0));
    EXPECT_NEAR(result.curve->step->eps_slower, 0.85, 4.0 * w.scatter / std::sqrt(10.0));
    ASSERT_TRUE(result.curve->step->impact);
    const auto impact = static_cast<std::size_t>(*result.curve->step->impact);
    for (const RestitutionSample& s : samples)
      if (s.impact == static_cast<std::int64_t>(impact)) EXPECT_GT(s.v_mps, 0.6);
  }
}

}  // namespace
}  // namespace bouncelab::fit
