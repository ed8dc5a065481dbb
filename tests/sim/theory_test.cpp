// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/theory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/sim.hpp"
#include "drop_statistics.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::sim {
namespace {

TEST(ContactOffset, OfTheLawsHasItsClosedForms) {
  for (const double n : {3e4, 1e6, 1e7}) {
    // 1e-9: the error stated; asperities cover the sphere but for exp(-15) at the fewest
    const ContactOffset constant = contact_offset(ConstantRadii{1e-3}, n);
    const double cover = 0.5 * n * 1e-3;
    EXPECT_NEAR(constant.variance * n / 2.0, 1.0 - (1.0 + cover) * std::exp(-cover), 1e-9);
    EXPECT_NEAR(constant.smooth_share, std::exp(-cover), 1e-15);
    const ContactOffset exponential = contact_offset(ExponentialRadii{1e-3}, n);
    EXPECT_NEAR(exponential.variance / 1e-3, 1.0 - std::exp(-cover), 1e-9);
    if (n > 1e5) {
      EXPECT_NEAR(constant.fourth_moment_ratio, 2.0, 1e-9);
      EXPECT_NEAR(exponential.fourth_moment_ratio, 2.0, 1e-9);
    }
  }
  for (const UniformRadii& law : {UniformRadii{0.5e-3, 1.5e-3}, UniformRadii{1.5e-3, 2.5e-3}}) {
    const ContactOffset offset = contact_offset(law, 1e6);  // the mean radius has no influence
    EXPECT_NEAR(offset.variance / (0.5 * std::sqrt(std::numbers::pi * 1e-3 / 1e6)), 1.0, 1e-9);
    EXPECT_NEAR(offset.fourth_moment_ratio, 16.0 / (3.0 * std::numbers::pi), 1e-9);
  }
}

TEST(ContactOffset, OfLawsWithoutClosedFormJoinThoseThatHaveOne) {
  // a normal law of vanishing width is the constant one, to the order sd/(2/N) of the heights that matter
  EXPECT_NEAR(contact_offset(NormalRadii{1e-3, 1e-8}, 1e5).variance / 2e-5, 1.0, 1e-3);
  // a lognormal law of small sigma is the normal one, to the order sigma z of its tail, z = 4 at N = 1e5
  const double lognormal = contact_offset(LognormalRadii{1e-3, 1e-3}, 1e5).variance;
  EXPECT_NEAR(lognormal / contact_offset(NormalRadii{1e-3, 1e-6}, 1e5).variance, 1.0, 4e-3);
}

TEST(ContactOffset, OfDrawnSurfacesIsThatOfTheirLaw) {
  const Ball ball;
  for (const char* text :
       {"constant:1e-3", "uniform:0.5e-3,1.5e-3", "normal:1e-3,1e-4", "lognormal:1e-3,0.1", "exponential:1e-3"}) {
    const RadiusLaw law = radius_law_from_text(text);
    std::vector<double> variance, ratio;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      const Surface surface = make_surface(ball, 10'000, law, seed);
      const ContactOffset offset = contact_offset(surface, Envelope(ball, surface), 20'000);
      variance.push_back(offset.variance);
      ratio.push_back(offset.fourth_moment_ratio);
    }
    const ContactOffset expected = contact_offset(law, 10'000);
    // four and a half standard errors: p = .003 of Student's t with 7 degrees of freedom, of 10 comparisons
    const double se = 4.5 / std::sqrt(7.0);
    EXPECT_NEAR(testing::mean(variance), expected.variance, se * testing::sd(variance)) << text;
    EXPECT_NEAR(testing::mean(ratio), expected.fourth_moment_ratio, se * testing::sd(ratio)) << text;
    EXPECT_LT(testing::sd(variance), 0.1 * expected.variance) << text;
  }
}

TEST(ContactOffset, RefusesWhatIsNoSurface) {
  EXPECT_THROW(contact_offset(ConstantRadii{-1.0}, 1e5), InvalidArgument);
  EXPECT_THROW(contact_offset(ConstantRadii{}, 0.0), InvalidArgument);
}

TEST(ContactFactor, IsThatOfTheCollision) {
  Ball thin_shell;
  thin_shell.inertia_factor = 2.0 / 3.0;
  EXPECT_NEAR(contact_factor(thin_shell, PaperContact{}), 0.6, 1e-15);  // rounding
  for (const Ball& ball : {Ball{}, thin_shell})
    for (const ContactModel& model :
         {ContactModel{PaperContact{}}, ContactModel{PaperContact{0.0}}, ContactModel{FrictionlessContact{}},
          ContactModel{CoulombContact{0.2}}, ContactModel{CoulombContact{0.0}}, ContactModel{StrongeContact{0.2}},
          ContactModel{StrongeContact{0.0}}}) {
      const double theta = 1e-3;
      const Vector3 lever{theta * ball.radius_m, 0.0, -ball.radius_m};
      const Collision c = collide(ball, ConstantLaw{0.9}, model, lever, {{0.0, 0.0, -1.0}, {}});
      const double loss = 1.9 / (1.0 + c.after.velocity_mps.z) - 1.0;  // c theta^2
      EXPECT_NEAR(loss / (theta * theta), contact_factor(ball, model), 1e-5)
          << describe(model);  // theta^2, rounding/theta^2
    }
}

/// The surface of a test, its drops and its q.
struct Experiment {
  SimulationConfig config;
  Impacts impacts;
  double q = 0.0;
};

Experiment experiment(const RadiusLaw& law, std::int64_t n_asperities, std::int64_t n_drops,
                      const ContactModel& contact = PaperContact{}, double spin_radps = 0.0,
                      std::int64_t n_impacts = 95) {
  Experiment e;
  e.config.contact = contact;
  e.config.n_drops = n_drops;
  e.config.n_impacts_max = n_impacts;
  e.config.n_threads = 1;
  e.config.with_state = true;
  e.config.start_spin_radps = {spin_radps, 0.0, 0.0};
  const Surface surface = make_surface(e.config.ball, n_asperities, law, 1);
  e.impacts = simulate(e.config, surface).impacts;
  e.q = contact_factor(e.config.ball, contact) * contact_offset(law, static_cast<double>(n_asperities)).variance;
  return e;
}

/// Mean distance on one side of the peak of impacts near speed v.
testing::Estimate measured(const Experiment& e, double v_mps, double testing::Laplace::*side) {
  return testing::by_drop(20, [&](const std::function<bool(std::int64_t)>& counts) {
    std::vector<double> x;
    for (const Impact& i : e.impacts.rows)
      if (std::abs(i.v_mps - v_mps) < 0.03 && counts(i.drop))
        x.push_back(i.eps_macro - restitution(e.config.law, i.v_mps));
    std::sort(x.begin(), x.end());
    return testing::laplace(x).*side;
  });
}

void expect_slopes(const Experiment& e) {
  for (const double v : {0.3, 0.6, 1.0}) {
    const FluctuationSides expected = expected_sides(e.config, e.q, v);
    const testing::Estimate below = measured(e, v, &testing::Laplace::below);
    const testing::Estimate above = measured(e, v, &testing::Laplace::above);
    // three and a half standard errors of about 2 %, and 2 %: the window is not a point, s2 is that of one surface
    EXPECT_NEAR(below.value, expected.below, 3.5 * below.se + 0.02 * expected.below) << v;
    EXPECT_NEAR(above.value, expected.above, 3.5 * above.se + 0.02 * expected.above) << v;
    EXPECT_LT(below.se, 0.04 * below.value);
  }
}

TEST(Theory, SlopesAreThoseOfSimulatedDrops) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  expect_slopes(experiment(ConstantRadii{}, 71'378, 1200));
  expect_slopes(experiment(ConstantRadii{}, 71'378, 1200, FrictionlessContact{}));
}

TEST(Theory, TransformsOfSimulatedImpactsAreUniformWhateverTheRuleOfContact) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  for (const ContactModel& contact : {ContactModel{PaperContact{}}, ContactModel{FrictionlessContact{}},
                                      ContactModel{PaperContact{0.5}}, ContactModel{CoulombContact{0.2}}}) {
    const Experiment e = experiment(ConstantRadii{}, 71'378, 200, contact);
    const double p = testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q));
    EXPECT_GT(p, 1e-3) << describe(contact);  // of four
    const double of_wrong_q = testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, 1.25 * e.q));
    EXPECT_LT(of_wrong_q, 1e-6) << describe(contact);  // 11 % too wide a law is seen at 19,000 impacts
  }
}

TEST(Theory, HoldsForExponentialRadiiToo) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  Experiment e = experiment(ExponentialRadii{2e-5}, 1'000'000, 1000);
  expect_slopes(e);  // of the order of 2e-5 R: asperities cover the sphere ten times over
  e.impacts.rows.resize(300 * 95);
  EXPECT_GT(testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q)), 1e-3);
}

TEST(Theory, OfUniformRadiiIsNearlyRight) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // offsets are flatter than normal: 19,000 transforms tell, and they are off by little
  const Experiment e = experiment(UniformRadii{}, 1'000'000, 200);
  const std::vector<double> u = probability_transforms(e.impacts, e.config.law, e.q);
  EXPECT_LT(testing::kolmogorov_p(u), 1e-3);
  double mean_square = 0.0;
  for (const double x : u) mean_square += x * x / static_cast<double>(u.size());
  EXPECT_NEAR(mean_square, 1.0 / 3.0, 0.02);  // 1.5 % off in the transforms themselves
}

TEST(Theory, OfSlopesLeavesItsRangeWhereTheScatterChangesTheSpeeds) {
  // exponential radii of 1e-3, q = 7e-4: speeds are a tenth and more from those of a smooth ball, which S is of
  const Experiment e = experiment(ExponentialRadii{1e-3}, 1'000'000, 1000);
  const testing::Estimate below = measured(e, 0.3, &testing::Laplace::below);
  const FluctuationSides expected = expected_sides(e.config, e.q, 0.3);
  EXPECT_LT(below.value + 4.0 * below.se, expected.below);
  EXPECT_GT(below.value, 0.6 * expected.below);
  // given the drop's own past the law holds on: early impacts, before any meets the ball on its way up
  Impacts early;
  for (const Impact& i : e.impacts.rows)
    if (i.impact < 40) early.rows.push_back(i);
  EXPECT_GT(testing::kolmogorov_p(probability_transforms(early, e.config.law, e.q)), 1e-3);
}

TEST(Theory, ContactsAreWeightedByTheirSpeedOfApproach) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  // v_c - v = sqrt(w) t_x, and t_x has the mean q sqrt(w)/v: the mean of (v_c - v)/v is q w/v^2, not 0
  const Experiment e = experiment(ExponentialRadii{1e-3}, 1'000'000, 6000, PaperContact{}, 0.0, 50);
  const double mass = mass_kg(e.config.ball);
  const testing::Estimate slope = testing::by_drop(20, [&](const std::function<bool(std::int64_t)>& counts) {
    double excess = 0.0, expected = 0.0;
    for (std::size_t k = 0; k < e.impacts.rows.size(); ++k) {
      const Impact& i = e.impacts.rows[k];
      const auto& energy_j = e.impacts.states[k].energy_j;
      const double w = 2.0 * (energy_j[1] + energy_j[2]) / mass;
      if (!counts(i.drop) || e.q * w > 0.1 * i.v_mps * i.v_mps) continue;  // terms of the next order
      excess += (i.v_contact_mps - i.v_mps) / i.v_mps;
      expected += e.q * w / (i.v_mps * i.v_mps);
    }
    return excess / expected;
  });
  EXPECT_NEAR(slope.value, 1.0, 4.0 * slope.se);
  EXPECT_LT(slope.se, 0.12);  // far from 0; 12,000 drops give 0.997 +- 0.065
}

TEST(Theory, RefusesImpactsOnTheWayUp) {
  Experiment e = experiment(ConstantRadii{}, 1000, 1);
  e.impacts.rows[5].v_mps *= -1.0;
  EXPECT_THROW(probability_transforms(e.impacts, e.config.law, e.q), InvalidArgument);
}

TEST(Theory, ReservoirFromTheResidualsErrsAsItStates) {
  const Experiment e = experiment(ConstantRadii{}, 71'378, 600);
  double w = 0.0, variance = 0.0, square_error = 0.0, error = 0.0, stated = 0.0, n = 0.0;
  for (std::size_t k = 0; k < e.impacts.rows.size(); ++k) {
    const Impact& i = e.impacts.rows[k];
    if (i.impact == 0) w = variance = 0.0;
    const auto& energy_j = e.impacts.states[k].energy_j;
    const double off = w - 2.0 * (energy_j[1] + energy_j[2]) / mass_kg(e.config.ball);
    if (i.impact == 90) {
      error += off;
      square_error += off * off;
      stated += variance;
      n += 1.0;
    }
    const double eps = restitution(e.config.law, i.v_mps), r = i.eps_macro - eps;
    const Fluctuation fluctuation(e.q, {i.v_mps, eps, restitution_slope(e.config.law, i.v_mps), w});
    variance += fluctuation.reservoir_sd(r) * fluctuation.reservoir_sd(r);
    w = fluctuation.reservoir_after(r);
  }
  // four standard errors of a mean and of a root mean square of 600 drops, these nearly normal
  EXPECT_LT(std::abs(error / n), 4.0 * std::sqrt(stated / n / n));
  EXPECT_NEAR(std::sqrt(square_error / stated), 1.0, 4.0 / std::sqrt(2.0 * n));
}

TEST(Theory, OfAReleaseWithSpinNeedsItsReservoir) {
  const double spin_radps = 20.0;
  const Experiment e = experiment(ConstantRadii{}, 71'378, 200, FrictionlessContact{}, spin_radps);
  const double u = spin_radps * e.config.ball.radius_m;
  const double w = u * u / contact_factor(e.config.ball, e.config.contact);
  EXPECT_LT(testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q)), 1e-6);
  EXPECT_GT(testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q, w)), 1e-3);
  EXPECT_THROW(expected_sides(e.config, e.q, 0.5), InvalidArgument);
}

TEST(Theory, RefusesWhatNoDropFromRestDoes) {
  EXPECT_THROW(expected_sides({}, 1e-5, 1.4), InvalidArgument);
  EXPECT_THROW(expected_sides({}, 1e-5, 0.0), InvalidArgument);
  SimulationConfig tilted;
  tilted.tilt_rad = 0.01;
  EXPECT_THROW(expected_sides(tilted, 1e-5, 0.5), InvalidArgument);
  SimulationConfig elastic;
  elastic.law = ConstantLaw{1.0};
  EXPECT_THROW(expected_sides(elastic, 1e-5, 0.5), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::sim
