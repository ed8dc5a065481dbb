// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "../reference/brute_force.hpp"
#include "bouncelab/sim/sim.hpp"

namespace bouncelab {
namespace {

double largest(Vector3 a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }
Vector3 vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// Each next impact recomputed by brute force from the stated state of the one before.
void expect_brute_force_agrees(const RadiusLaw& law, std::int64_t n_asperities, const SimulationConfig& config) {
  const Surface surface = make_surface(config.ball, n_asperities, law, 11);
  const SimulationResult result = simulate(config, surface);
  const auto& rows = result.impacts.rows;
  ASSERT_GT(rows.size(), 50U);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k].drop != rows[k - 1].drop) continue;
    const BallState start = reference::state_after(config.ball, result.impacts.states[k - 1]);
    const FirstContact twin =
        reference::first_contact(config.ball, surface, start, config.gravity_mps2, rows[k - 1].asperity);
    ASSERT_EQ(twin.asperity, rows[k].asperity) << to_text(law) << ", impact " << k;
    // 1e-12 s: the simulator's claim (2e-15 s and the rounding of heights); both clocks start at the last impact, but
    // the table holds times since release, whose last digit is 2e-15 s
    ASSERT_NEAR(twin.dt_s, rows[k].t_s - rows[k - 1].t_s, 1e-12) << to_text(law) << ", impact " << k;
    const ImpactState& state = result.impacts.states[k];
    // velocities follow the time: 1e-14 s of turning by R omega^2, and roundings of speeds near 1
    const double turning_mps2 = config.ball.radius_m * norm2(start.motion.spin_radps);
    const double tolerance_mps = 1e-11 + 1e-14 * turning_mps2;
    ASSERT_LT(largest(twin.state.motion.velocity_mps - vector(state.velocity_mps)), tolerance_mps);
    const Motion after = reference::collide_paper(config.ball, config.law, 1.0, twin.lever_m, twin.state.motion);
    ASSERT_LT(largest(after.velocity_mps - vector(state.velocity_after_mps)), tolerance_mps);
    ASSERT_LT(largest(after.spin_radps - vector(state.spin_after_radps)) * config.ball.radius_m, tolerance_mps);
  }
}

SimulationConfig two_drops() {
  SimulationConfig config;
  config.n_drops = 2;
  config.with_state = true;
  config.n_threads = 1;
  return config;
}

TEST(FirstContact, AgreesWithBruteForceForUniformRadii) {
  expect_brute_force_agrees(UniformRadii{}, 200'000, two_drops());
}
TEST(FirstContact, AgreesWithBruteForceForExponentialRadii) {
  expect_brute_force_agrees(ExponentialRadii{}, 200'000, two_drops());
}
TEST(FirstContact, AgreesWithBruteForceForConstantRadii) {
  expect_brute_force_agrees(ConstantRadii{}, 20'000, two_drops());
}
TEST(FirstContact, AgreesWithBruteForceForNormalAndLognormalRadii) {
  expect_brute_force_agrees(NormalRadii{}, 20'000, two_drops());
  expect_brute_force_agrees(LognormalRadii{1e-3, 0.5}, 20'000, two_drops());
}
TEST(FirstContact, AgreesWithBruteForceWhereTheSmoothSphereTouchesOften) {
  expect_brute_force_agrees(UniformRadii{}, 1'000, two_drops());
}
TEST(FirstContact, AgreesWithBruteForceForAFastSpinningBall) {
  SimulationConfig config = two_drops();
  config.start_spin_radps = {3000.0, -2000.0, 500.0};  // R omega = 11 m/s: it strikes while it rises
  expect_brute_force_agrees(ExponentialRadii{}, 20'000, config);
}

TEST(FirstContact, OfASmoothBallIsTheClosedFormOfTheParabola) {
  const Ball ball;
  const Envelope envelope(ball, Surface{});
  BallState start;
  start.clearance_m = 0.1;
  const FirstContact contact = find_first_contact(ball, envelope, start, {0, 0, -9.81}, std::nullopt);
  EXPECT_EQ(contact.asperity, -1);
  EXPECT_NEAR(contact.dt_s, std::sqrt(2 * 0.1 / 9.81), 1e-15);  // rounding of 0.14
}

TEST(FirstContact, IsEarlierByTheHeightOfTheAsperityBelow) {
  const Ball ball;
  const Surface surface{{{{0, 0, -1}, 3e-6}}};
  const Envelope envelope(ball, surface);
  BallState start;
  start.clearance_m = 0.1;
  const FirstContact contact = find_first_contact(ball, envelope, start, {0, 0, -9.81}, std::nullopt);
  EXPECT_EQ(contact.asperity, 0);
  EXPECT_NEAR(contact.dt_s, std::sqrt(2 * (0.1 - 3e-6) / 9.81), 1e-15);
}

TEST(FirstContact, RefusesGravityThatDoesNotPullToThePlate) {
  const Ball ball;
  EXPECT_THROW(find_first_contact(ball, Envelope(ball, Surface{}), BallState{}, {9.81, 0, 0}, std::nullopt),
               std::exception);
}

}  // namespace
}  // namespace bouncelab
