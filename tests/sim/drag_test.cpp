// SPDX-License-Identifier: GPL-3.0-or-later
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bouncelab/sim/sim.hpp"

namespace bouncelab::sim {
namespace {

constexpr double kG = 9.81;

/// z'' = -g + drag, as GSL wants it.
int fall(double, const double y[], double dydt[], void*) {
  dydt[0] = y[1];
  dydt[1] = -kG + drag_acceleration_mps2(Ball{}, Air{}, {0, 0, y[1]}).z;
  return GSL_SUCCESS;
}

TEST(Drag, IsStokesLawForSlowMotion) {
  const Ball ball;
  const Air air;
  const double v = 1e-9;
  // 6 pi mu R v / m; the correction 0.15 Re^0.687 is 3e-6 at Re = 4e-7
  const double stokes = 6 * std::numbers::pi * air.viscosity_pas * ball.radius_m * v / mass_kg(ball);
  EXPECT_NEAR(-drag_acceleration_mps2(ball, air, {v, 0, 0}).x / stokes, 1.0, 2e-5);
}

TEST(Drag, FlightAgreesWithAnAdaptiveIntegrator) {
  const Ball ball;
  const Envelope envelope(ball, Surface{});
  for (const double v0 : {0.2, 0.7, 1.4}) {
    BallState start;
    start.motion.velocity_mps = {0, 0, v0};
    const FirstContact contact = find_first_contact(ball, envelope, start, {0, 0, -kG}, -1, Air{});
    gsl_odeiv2_system system{fall, nullptr, 2, nullptr};
    gsl_odeiv2_driver* driver = gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 1e-6, 1e-16, 1e-15);
    double t = 0.0, y[2] = {0.0, v0};
    ASSERT_EQ(gsl_odeiv2_driver_apply(driver, &t, contact.dt_s, y), GSL_SUCCESS);
    gsl_odeiv2_driver_free(driver);
    // both integrators' errors: 1e-12 m claimed, a few times that allowed
    EXPECT_NEAR(y[0], 0.0, 4e-12) << v0;
    EXPECT_NEAR(y[1], contact.state.motion.velocity_mps.z, 1e-11) << v0;
  }
}

TEST(Drag, IsAccountedForInTheLedger) {
  SimulationConfig config;
  config.air = Air{};
  config.n_drops = 2;
  config.start_velocity_mps = {0.1, 0.0};
  const SimulationResult result = simulate(config, make_surface(config.ball, 20'000, UniformRadii{}, 1));
  EXPECT_LT(std::abs(result.energy.closure()), 1e-12);
  EXPECT_GT(result.energy.drag_j, 0.0);
  EXPECT_LT(result.energy.drag_j, 0.1 * result.energy.released_j);
}

TEST(Drag, FarBelowGravityChangesNothing) {
  // in a vacuum the dragged path is the parabola
  const Ball ball;
  const Surface surface = make_surface(ball, 20'000, UniformRadii{}, 1);
  const Envelope envelope(ball, surface);
  BallState start;
  start.clearance_m = 0.02;
  start.motion = {{0.1, 0.0, 0.5}, {20.0, -30.0, 5.0}};
  const FirstContact air = find_first_contact(ball, envelope, start, {0, 0, -kG}, std::nullopt, Air{1e-20, 1e-20});
  const FirstContact none = find_first_contact(ball, envelope, start, {0, 0, -kG}, std::nullopt);
  EXPECT_EQ(air.asperity, none.asperity);
  EXPECT_NEAR(air.dt_s, none.dt_s, 1e-14);  // a hundred steps of Runge-Kutta rounding
}

}  // namespace
}  // namespace bouncelab::sim
