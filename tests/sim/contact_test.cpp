// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "../reference/brute_force.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/experiment.hpp"

namespace bouncelab::sim {
namespace {

constexpr double kRounding = 1e-12;  // of speeds near 1 m/s and lever arms of 3 mm, with a margin for cancellation

/// An eccentric approach: lever up to 10 degrees off the vertical, speeds near 1 m/s, spin up to R omega = 1 m/s.
struct Approach {
  Vector3 lever_m;
  Motion motion;
};
Approach random_approach(std::uint64_t k) {
  Random random(3, RandomStream::test, k);
  const Ball ball;
  const double r = ball.radius_m;
  const Vector3 lever{r * random.uniform(-0.17, 0.17), r * random.uniform(-0.17, 0.17), -r};
  const Vector3 velocity{random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), -random.uniform(0.6, 1.4)};
  const Vector3 spin{random.uniform(-300, 300), random.uniform(-300, 300), random.uniform(-300, 300)};
  return {lever, {velocity, spin}};
}

Vector3 contact_velocity(const Motion& m, Vector3 lever) { return m.velocity_mps + cross(m.spin_radps, lever); }

TEST(Collide, NormalSpeedAtTheContactIsReversedByEpsInEveryModel) {
  const Ball ball;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [lever, before] = random_approach(k);
    for (const ContactModel& model :
         {ContactModel{PaperContact{}}, ContactModel{FrictionlessContact{}}, ContactModel{CoulombContact{0.1}}}) {
      const Collision c = collide(ball, SeriesLaw{}, model, lever, before);
      const double v = contact_velocity(before, lever).z;
      EXPECT_NEAR(contact_velocity(c.after, lever).z, -restitution(SeriesLaw{}, -v) * v, kRounding);
      EXPECT_DOUBLE_EQ(c.v_contact_mps, -v);
    }
  }
}

TEST(Collide, ConservesAngularMomentumAboutThePointOfContact) {
  const Ball ball;
  const double m = mass_kg(ball), j = moment_of_inertia_kgm2(ball);
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [lever, before] = random_approach(k);
    for (const ContactModel& model :
         {ContactModel{PaperContact{0.3}}, ContactModel{FrictionlessContact{}}, ContactModel{CoulombContact{0.1}}}) {
      const Motion after = collide(ball, SeriesLaw{}, model, lever, before).after;
      const auto about_contact = [&, lever = lever](const Motion& s) {
        return (j / (m * ball.radius_m)) * s.spin_radps - (1.0 / ball.radius_m) * cross(lever, s.velocity_mps);
      };
      EXPECT_LT(norm(about_contact(after) - about_contact(before)), kRounding);
    }
  }
}

TEST(Collide, PaperRuleIsTheSolutionOfItsLinearSystem) {
  const Ball ball;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [lever, before] = random_approach(k);
    for (const double beta : {1.0, 0.5, 0.0, -1.0}) {
      const Motion after = collide(ball, SeriesLaw{}, PaperContact{beta}, lever, before).after;
      const Motion twin = reference::collide_paper(ball, SeriesLaw{}, beta, lever, before);
      EXPECT_LT(norm(after.velocity_mps - twin.velocity_mps), kRounding);
      EXPECT_LT(norm(after.spin_radps - twin.spin_radps) * ball.radius_m, kRounding);
      const Vector3 v = contact_velocity(before, lever), v_after = contact_velocity(after, lever);
      EXPECT_NEAR(v_after.x, beta * v.x, kRounding);  // eq. 7, literally
      EXPECT_NEAR(v_after.y, beta * v.y, kRounding);
    }
  }
}

TEST(Collide, FrictionlessImpactNeverCreatesEnergyAndDissipatesTheClosedForm) {
  const Ball ball;
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [lever, before] = random_approach(k);
    const Collision c = collide(ball, ConstantLaw{0.9}, FrictionlessContact{}, lever, before);
    const ImpactEnergy energy = impact_energy(ball, before, c.after);
    // E_before - E_after = (1 - eps^2) v_c^2 / (2 e_z.K e_z)
    const double r2 = lever.x * lever.x + lever.y * lever.y;
    const double mobility = 1.0 / mass_kg(ball) + r2 / moment_of_inertia_kgm2(ball);
    const double expected = (1.0 - 0.81) * c.v_contact_mps * c.v_contact_mps / (2.0 * mobility);
    EXPECT_NEAR(energy.dissipated_j / expected, 1.0, 1e-11);  // differences of energies ten times larger
    EXPECT_EQ(energy.created_j, 0.0);
    EXPECT_EQ(c.impulse_ns.x, 0.0);
  }
}

TEST(Collide, CoulombSlidesByTheConeAndSticksBelowIt) {
  const Ball ball;
  const Vector3 lever{0, 0, -ball.radius_m};
  const Motion fast{{1.0, 0, -1.0}, {}}, slow{{0.01, 0, -1.0}, {}};
  const Collision slides = collide(ball, ConstantLaw{1.0}, CoulombContact{0.1}, lever, fast);
  // textbook sliding: dv_x = -mu (1 + eps) v_n, and omega' = (r x P)/J = (5/2) dv_x / R about y, seen from above
  EXPECT_NEAR(slides.after.velocity_mps.x, 1.0 - 0.1 * 2.0, kRounding);
  EXPECT_NEAR(slides.after.spin_radps.y * ball.radius_m, 2.5 * 0.2, kRounding);
  const Collision sticks = collide(ball, ConstantLaw{1.0}, CoulombContact{0.1}, lever, slow);
  EXPECT_NEAR(contact_velocity(sticks.after, lever).x, 0.0, kRounding);
  EXPECT_NEAR(sticks.after.velocity_mps.x, 5.0 / 7.0 * 0.01, kRounding);  // rolling: v' = 5/7 v
}

TEST(Collide, CoulombTendsToFrictionlessAndToStickingAtItsEnds) {
  const Ball ball;
  for (std::uint64_t k = 0; k < 50; ++k) {
    const auto [lever, before] = random_approach(k);
    const Collision none = collide(ball, SeriesLaw{}, CoulombContact{0.0}, lever, before);
    const Collision frictionless = collide(ball, SeriesLaw{}, FrictionlessContact{}, lever, before);
    EXPECT_LT(norm(none.after.velocity_mps - frictionless.after.velocity_mps), kRounding);
    const Collision much = collide(ball, SeriesLaw{}, CoulombContact{100.0}, lever, before);
    const Collision sticking = collide(ball, SeriesLaw{}, PaperContact{0.0}, lever, before);
    EXPECT_LT(norm(much.after.velocity_mps - sticking.after.velocity_mps), kRounding);
  }
}

TEST(ContactModel, ParametersOutOfRangeAreRefused) {
  EXPECT_THROW(validate(PaperContact{1.5}), InvalidArgument);
  EXPECT_THROW(validate(CoulombContact{-0.1}), InvalidArgument);
  EXPECT_THROW(validate(CoulombContact{NAN}), InvalidArgument);
}

SimulationConfig config_with_states() {
  SimulationConfig config;
  config.n_drops = 40;
  config.n_impacts_max = 80;
  config.with_state = true;
  config.n_threads = 1;
  return config;
}

TEST(EnergyShares, OfARoughBallMoveFromVerticalToRotationAndHorizontalMotionBounceByBounce) {
  const SimulationConfig config = config_with_states();
  const Surface surface = make_surface(config.ball, 20'000, UniformRadii{}, 1);
  const std::vector<EnergyShares> shares = energy_shares(config.ball, simulate(config, surface).impacts);
  ASSERT_EQ(shares.size(), 80u);
  for (const EnergyShares& s : shares) {
    EXPECT_EQ(s.n, 40u);
    EXPECT_NEAR(s.vertical + s.horizontal + s.rotational, 1.0, 1e-14);  // 40 sums of three quotients, rounded
    EXPECT_LE(s.rotational_lo, s.rotational_hi);
  }
  EXPECT_EQ(shares[0].vertical, 1.0);  // released at rest
  // asperities do not pull back what they set going: over decades of bounces the share grows
  EXPECT_GT(shares[10].rotational, shares[1].rotational);
  EXPECT_GT(shares[79].rotational, shares[10].rotational);
  EXPECT_LT(shares[79].vertical, 1.0);
}

TEST(Reservoir, AfterEachImpactIsThatOfItsState) {
  SimulationConfig config;
  config.n_drops = 1;
  config.n_impacts_max = 3;
  config.with_state = true;
  SimulationResult result = simulate(config, make_surface(config.ball, 20'000, ConstantRadii{1e-3}, 4));
  const auto after = reservoirs_after(config.ball, result.impacts);
  ASSERT_EQ(after.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const KineticEnergy energy = impact_energy(config.ball, result.impacts.states[k]).after;
    const double m = mass_kg(config.ball);
    EXPECT_NEAR(after[k].sideways_m2ps2, 2.0 * energy.horizontal_j / m, 1e-15);  // rounding
    EXPECT_LE(after[k].spin_m2ps2, 2.0 * energy.rotational_j / m + 1e-15);       // less the spin about the normal
    EXPECT_GT(after[k].spin_m2ps2, 0.9 * 2.0 * energy.rotational_j / m);  // which is of second order in offsets of .01
  }
  result.impacts.states.clear();
  EXPECT_THROW(reservoirs_after(config.ball, result.impacts), InvalidArgument);
  EXPECT_THROW(energy_shares(config.ball, result.impacts), InvalidArgument);
}

}  // namespace

}  // namespace bouncelab::sim
