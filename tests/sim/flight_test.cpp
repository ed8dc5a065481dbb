// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "../reference/brute_force.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/flight.hpp"
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

constexpr double kG = 9.81;

/// z'' = -g + drag, as GSL wants it.
int fall(double, const double y[], double dydt[], void* ball) {
  dydt[0] = y[1];
  dydt[1] = -kG + drag_acceleration_mps2(*static_cast<Ball*>(ball), Air{}, {0, 0, y[1]}).z;
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
  // a height that the ball is off by is one in time over its speed; twice what the integrator claims is allowed
  for (const auto& [named, height_m] : {std::pair{"steel:6mm", 4e-13}, {"table-tennis", 12e-12}}) {
    Ball ball = ball_from_text(named);
    const Envelope envelope(ball, Surface{});
    for (const double v0 : {0.2, 0.7, 1.4}) {
      BallState start;
      start.motion.velocity_mps = {0, 0, v0};
      const FirstContact contact = find_first_contact(ball, envelope, start, {0, 0, -kG}, -1, Air{});
      gsl_odeiv2_system system{fall, nullptr, 2, &ball};
      gsl_odeiv2_driver* driver = gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 1e-6, 1e-16, 1e-15);
      double t = 0.0, y[2] = {0.0, v0};
      ASSERT_EQ(gsl_odeiv2_driver_apply(driver, &t, contact.dt_s, y), GSL_SUCCESS);
      gsl_odeiv2_driver_free(driver);
      EXPECT_NEAR(y[0], 0.0, height_m) << named << v0;
      EXPECT_NEAR(y[1], contact.state.motion.velocity_mps.z, 1e-11) << named << v0;
    }
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

Vector3 random_direction(Random& random) {
  for (;;) {
    const Vector3 a{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (norm2(a) > 0.01 && norm2(a) < 1.0) return normalized(a);
  }
}

/// Two axes across n.
struct Axes {
  Vector3 first, second;
};
Axes axes_across(Vector3 n) {
  const Vector3 first = normalized(cross(n, std::abs(n.z) < 0.9 ? Vector3{0, 0, 1} : Vector3{1, 0, 0}));
  return {first, cross(n, first)};
}

Vector3 across(Vector3 a, Vector3 n) { return a - dot(a, n) * n; }

TEST(Patch, HertzRadiusOfThePapersBallOnGlass) {
  // 1/E* = .91/200e9 + .9516/70e9, delta = (15 m v^2/(16 E* sqrt R))^(2/5) = 9.5 um, by hand
  EXPECT_NEAR(hertz_patch_radius_m(Ball{}, kGlass, 1.0), 169e-6, 1e-6);
  const double ratio = hertz_patch_radius_m(Ball{}, kGlass, 0.3) / hertz_patch_radius_m(Ball{}, kGlass, 1.0);
  EXPECT_NEAR(ratio, std::pow(0.3, 0.4), 1e-14);  // rounding
}

TEST(Patch, OneAsperityUnderTheWholeDiscKeepsItsOffset) {
  const Ball ball;
  Random random(1, RandomStream::test, 0);
  const Surface surface{{{normalized(Vector3{1, 2, 3}), 2e-3 * ball.radius_m}}};
  const Envelope envelope(ball, surface);
  for (int k = 0; k < 20; ++k) {
    // within 20 mrad of the asperity, which is the highest up to sqrt(2 R_j/R) = 63 mrad from it
    const Vector3 u = surface.asperities[0].direction,
                  n = normalized(u + 0.02 * random.uniform() * random_direction(random));
    EXPECT_LT(norm(mean_gradient(envelope, n, 0.03) - across(u, n)), 1e-13);  // rounding of 1 over a disc of .03
  }
}

TEST(Patch, IsTheMeanOfTheOffsetsInTheDisc) {
  const Ball ball;
  const Surface surface = make_surface(ball, 100'000, UniformRadii{}, 3);
  const Envelope envelope(ball, surface);
  Random random(2, RandomStream::test, 0);
  double sum2 = 0.0, error2 = 0.0;
  for (int k = 0; k < 30; ++k) {
    const Vector3 n = random_direction(random);
    const auto [e1, e2] = axes_across(n);
    const double alpha = 0.056;  // 169 um
    Vector3 mean;
    constexpr int kSide = 150;
    int n_in = 0;
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j) {
        const double x = alpha * ((2 * i + 1.0) / kSide - 1.0), y = alpha * ((2 * j + 1.0) / kSide - 1.0);
        if (x * x + y * y > alpha * alpha) continue;
        ++n_in;
        const Vector3 here = normalized(n + x * e1 + y * e2);
        const Envelope::Support support = envelope.support(here);
        if (support.asperity < 0) continue;
        mean = mean + across(surface.asperities[static_cast<std::size_t>(support.asperity)].direction, here);
      }
    const Vector3 exact = (1.0 / n_in) * mean, found = mean_gradient(envelope, n, alpha);
    sum2 += norm2(across(exact, n));
    error2 += norm2(across(found - exact, n));
  }
  // of the grid's sum (its pixels at facets' edges) and of the 256 points together; a wrong weight of the disc, or the
  // offset of first contact in place of the mean, would be off by as much as it is long
  EXPECT_LT(std::sqrt(error2 / sum2), 0.05);
}

SimulationConfig config_with_patch(bool patch) {
  SimulationConfig config;
  config.n_drops = 12;
  config.n_impacts_max = 60;
  config.n_threads = 1;
  config.with_state = true;
  if (patch) config.patch_plate = kGlass;
  return config;
}

TEST(Patch, SmoothsTheContactAndTheLedgerStillCloses) {
  const SimulationConfig one = config_with_patch(false), patch = config_with_patch(true);
  const Surface surface = make_surface(one.ball, 200'000, UniformRadii{}, 3);
  const auto scatter = [](const SimulationResult& result) {
    double sum2 = 0.0;
    for (const Impact& impact : result.impacts.rows) {
      const double r = impact.eps_macro - impact.eps_contact;
      sum2 += r * r;
    }
    return std::sqrt(sum2 / static_cast<double>(result.impacts.rows.size()));
  };
  const SimulationResult single = simulate(one, surface), smoothed = simulate(patch, surface);
  ASSERT_EQ(smoothed.impacts.rows.size(), single.impacts.rows.size());
  // some ten facets across the disc average out
  EXPECT_LT(scatter(smoothed), 0.5 * scatter(single));
  EXPECT_GT(scatter(smoothed), 0.0);
  EXPECT_LT(std::abs(smoothed.energy.closure()), 1e-12);  // a thousand roundings of 1e-16
}

}  // namespace

}  // namespace bouncelab::sim
