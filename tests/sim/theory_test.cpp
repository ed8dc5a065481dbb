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
#include "support/statistics.hpp"

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
  }
  for (const UniformRadii& law : {UniformRadii{0.5e-3, 1.5e-3}, UniformRadii{1.5e-3, 2.5e-3}}) {
    const ContactOffset offset = contact_offset(law, 1e6);  // the mean radius has no influence
    EXPECT_NEAR(offset.variance / (0.5 * std::sqrt(std::numbers::pi * 1e-3 / 1e6)), 1.0, 1e-9);
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
    std::vector<double> variance;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      const Surface surface = make_surface(ball, 10'000, law, seed);
      variance.push_back(contact_offset(surface, Envelope(ball, surface), 20'000).variance);
    }
    const ContactOffset expected = contact_offset(law, 10'000);
    // four and a half standard errors: p = .003 of Student's t with 7 degrees of freedom, of 5 comparisons
    const double se = 4.5 / std::sqrt(7.0);
    EXPECT_NEAR(testing::mean(variance), expected.variance, se * testing::sd(variance)) << text;
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
  // of the order of 2e-5 R: asperities cover the sphere ten times over
  const Experiment e = experiment(ExponentialRadii{2e-5}, 1'000'000, 300);
  EXPECT_GT(testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q)), 1e-3);
}

TEST(Theory, OfAReleaseWithSpinNeedsItsReservoir) {
  const double spin_radps = 20.0;
  const Experiment e = experiment(ConstantRadii{}, 71'378, 200, FrictionlessContact{}, spin_radps);
  const double u = spin_radps * e.config.ball.radius_m;
  const double w = u * u / contact_factor(e.config.ball, e.config.contact);
  EXPECT_LT(testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q)), 1e-6);
  EXPECT_GT(testing::kolmogorov_p(probability_transforms(e.impacts, e.config.law, e.q, w)), 1e-3);
}
TEST(Theory, RefusesAnImpactOnTheWayUp) {
  Experiment on_its_way_up = experiment(ConstantRadii{}, 1000, 1);
  on_its_way_up.impacts.rows[5].v_mps *= -1.0;
  EXPECT_THROW(probability_transforms(on_its_way_up.impacts, SeriesLaw{}, 1e-5), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::sim
