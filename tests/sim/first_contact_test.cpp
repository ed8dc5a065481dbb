// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "../reference/brute_force.hpp"
#include "bouncelab/sim/sim.hpp"

namespace bouncelab::sim {
namespace {

double largest(Vector3 a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }
Vector3 vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// Each next impact recomputed by brute force from the stated state of the one before.
void expect_brute_force_agrees(const Surface& surface, const SimulationConfig& config) {
  const SimulationResult result = simulate(config, surface);
  const auto& rows = result.impacts.rows;
  ASSERT_GT(rows.size(), 50U);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k].drop != rows[k - 1].drop) continue;
    const BallState start = reference::state_after(config.ball, result.impacts.states[k - 1]);
    const FirstContact twin =
        reference::first_contact(config.ball, surface, start, config.gravity_mps2, rows[k - 1].asperity);
    ASSERT_EQ(twin.asperity, rows[k].asperity) << "impact " << k;
    // 1e-12 s: the simulator's claim (2e-15 s and the rounding of heights); both clocks start at the last impact, but
    // the table holds times since release, whose last digit is 2e-15 s
    ASSERT_NEAR(twin.dt_s, rows[k].t_s - rows[k - 1].t_s, 1e-12) << "impact " << k;
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

SimulationConfig drops(std::int64_t n_drops) {
  SimulationConfig config;
  config.n_drops = n_drops;
  config.with_state = true;
  config.n_threads = 1;
  return config;
}

TEST(FirstContact, AgreesWithBruteForceForAllRadiiAndWhereTheSmoothSphereTouchesOften) {
  struct Case {
    RadiusLaw law;
    std::int64_t n_asperities, n_drops;
  };
  for (const Case& c :
       {Case{UniformRadii{}, 200'000, 3}, Case{ExponentialRadii{}, 200'000, 3}, Case{ConstantRadii{}, 20'000, 2},
        Case{NormalRadii{}, 20'000, 2}, Case{LognormalRadii{1e-3, 0.5}, 20'000, 2}, Case{UniformRadii{}, 1'000, 2}}) {
    SCOPED_TRACE(to_text(c.law) + " " + std::to_string(c.n_asperities));
    const SimulationConfig config = drops(c.n_drops);
    expect_brute_force_agrees(make_surface(config.ball, c.n_asperities, c.law, 11), config);
  }
}

TEST(FirstContact, AgreesWithBruteForceForAFastSpinningBall) {
  SimulationConfig config = drops(2);
  config.start_spin_radps = {3000.0, -2000.0, 500.0};  // R omega = 11 m/s: it strikes while it rises
  expect_brute_force_agrees(make_surface(config.ball, 20'000, ExponentialRadii{}, 11), config);
}

TEST(FirstContact, AgreesWithBruteForceWhereOneAsperityTowersAboveAMillion) {
  SimulationConfig config = drops(2);
  config.n_impacts_max = 30;
  config.start_spin_radps = {40.0, 0.0, 0.0};  // turns the tall one under the ball now and then
  Surface surface = make_surface(config.ball, 1'000'000, UniformRadii{}, 11);
  surface.asperities[123'456].radius_m = 0.05 * config.ball.radius_m;
  expect_brute_force_agrees(surface, config);
}

TEST(FirstContact, OfASpinningBallThatGrazesAgreesWithBruteForce) {
  // one asperity sweeps below the ball: its gap has a minimum with a curvature of R omega^2 = 12,000 m/s^2. Bisection
  // finds the height at which it just touches; from a little lower it closes at sqrt(2 R omega^2 depth)
  const Ball ball;
  constexpr double kSpin_radps = 2000.0, kAngle = 0.05;
  const Surface surface{{{{0.0, -std::sin(kAngle), -std::cos(kAngle)}, 5e-6}}};
  const Envelope envelope(ball, surface);
  BallState start;
  start.motion.spin_radps = {kSpin_radps, 0.0, 0.0};
  const auto touches = [&](double clearance_m) {
    start.clearance_m = clearance_m;
    return find_first_contact(ball, envelope, start, {0, 0, -9.81}, std::nullopt).asperity == 0;
  };
  double lo_m = 4e-6, hi_m = 2e-5;  // touches, and passes
  ASSERT_TRUE(touches(lo_m));
  ASSERT_FALSE(touches(hi_m));
  while (hi_m - lo_m > 1e-18) {
    const double middle_m = 0.5 * (lo_m + hi_m);
    if (middle_m == lo_m || middle_m == hi_m) break;
    (touches(middle_m) ? lo_m : hi_m) = middle_m;
  }
  for (const double depth_m : {1e-7, 1e-9, 1e-11, 1e-13, 1e-15, -1e-15, -1e-13, -1e-11, -1e-9, -1e-7}) {
    start.clearance_m = lo_m - depth_m;
    const FirstContact ours = find_first_contact(ball, envelope, start, {0, 0, -9.81}, std::nullopt);
    const FirstContact twin = reference::first_contact(ball, surface, start, 9.81, std::nullopt);
    EXPECT_EQ(ours.asperity, depth_m > 0.0 ? 0 : -1) << depth_m;
    EXPECT_EQ(twin.asperity, ours.asperity) << depth_m;
    // 1e-18 m of rounding over the closing speed
    const double closing_mps = std::sqrt(2.0 * ball.radius_m * kSpin_radps * kSpin_radps * std::abs(depth_m));
    EXPECT_NEAR(ours.dt_s, twin.dt_s, 1e-15 + 1e-18 / closing_mps) << depth_m;
  }
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
}  // namespace bouncelab::sim
