// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/contact.hpp"
#include "support/statistics.hpp"

namespace bouncelab::sim {
namespace {

/// A lever up to 10 degrees off the vertical, speeds near 1 m/s, spin up to R omega = 1 m/s; a tenth without spin and
/// sideways motion, a tenth without eccentricity.
struct RubbingApproach {
  Vector3 lever_m;
  Motion motion;
  double mu, eps;
};
RubbingApproach random_rubbing_approach(std::uint64_t k) {
  Random random(5, RandomStream::test, k);
  const double r = Ball{}.radius_m;
  const double eccentric = k % 10 == 1 ? 0.0 : 0.17 * r, moving = k % 10 == 2 ? 0.0 : 1.0;
  const Vector3 lever{random.uniform(-eccentric, eccentric), random.uniform(-eccentric, eccentric), -r};
  const double v = 0.3 * moving, w = 300.0 * moving;
  const Vector3 velocity{random.uniform(-v, v), random.uniform(-v, v), -random.uniform(0.6, 1.4)};
  const Vector3 spin{random.uniform(-w, w), random.uniform(-w, w), random.uniform(-w, w)};
  // half of the approaches lossless: there rounding and errors of a rule have nothing to hide behind
  const double mu = random.uniform(0.02, 1.0), eps = k % 2 == 0 ? 1.0 : random.uniform(0.0, 1.0);
  return {lever, {velocity, spin}, mu, eps};
}

Vector3 velocity_of_contact(const Motion& m, Vector3 lever) { return m.velocity_mps + cross(m.spin_radps, lever); }

bool approaches(const RubbingApproach& a) { return velocity_of_contact(a.motion, a.lever_m).z < -0.01; }

/// The definition followed in small equal steps of normal impulse, with the matrix K written out: first order.
struct Followed {
  Vector3 impulse;
  double compression_j = 0.0, friction_j = 0.0;
};
Followed follow(const Ball& ball, const RubbingApproach& a, int n_steps) {
  const double m = mass_kg(ball), j = moment_of_inertia_kgm2(ball);
  const Vector3 r = a.lever_m;
  const double diagonal = 1.0 / m + norm2(r) / j;
  const double kxx = diagonal - r.x * r.x / j, kyy = diagonal - r.y * r.y / j, kzz = diagonal - r.z * r.z / j;
  const double kxy = -r.x * r.y / j, kxz = -r.x * r.z / j, kyz = -r.y * r.z / j;
  const double det = kxx * kyy - kxy * kxy;
  Vector3 v = velocity_of_contact(a.motion, r);
  const double dp = -2.0 * v.z * m / n_steps;
  Followed f;
  double restitution_j = 0.0;
  while (v.z < 0.0 || restitution_j < a.eps * a.eps * f.compression_j) {
    // the force that ends the step without slip; where the cone does not hold it, friction against the slip
    const double sx = v.x / dp + kxz, sy = v.y / dp + kyz;
    double fx = -(kyy * sx - kxy * sy) / det, fy = -(kxx * sy - kxy * sx) / det;
    const double force = std::hypot(fx, fy);
    if (force > a.mu) {
      const double slip = std::hypot(v.x, v.y);
      fx = slip > 0.0 ? -a.mu * v.x / slip : a.mu * fx / force;
      fy = slip > 0.0 ? -a.mu * v.y / slip : a.mu * fy / force;
    }
    const Vector3 dv{dp * (kxx * fx + kxy * fy + kxz), dp * (kxy * fx + kyy * fy + kyz),
                     dp * (kxz * fx + kyz * fy + kzz)};
    const Vector3 mean = v + 0.5 * dv;
    (mean.z < 0.0 ? f.compression_j : restitution_j) += std::abs(mean.z) * dp;
    f.friction_j -= dp * (fx * mean.x + fy * mean.y);
    f.impulse = f.impulse + dp * Vector3{fx, fy, 1.0};
    v = v + dv;
  }
  return f;
}

TEST(Stronge, CreatesNoEnergyInThreeHundredThousandApproaches) {
  const Ball ball;
  const int n_approaches = test::repetitions(50'000, 300'000);
  int n = 0, n_coulomb_creates = 0;
  double worst = -1.0;
  for (std::uint64_t k = 0; n < n_approaches; ++k) {
    const RubbingApproach a = random_rubbing_approach(k);
    if (!approaches(a)) continue;
    ++n;
    const auto gain = [&](const ContactModel& model) {
      const Motion after = collide(ball, ConstantLaw{a.eps}, model, a.lever_m, a.motion).after;
      const ImpactEnergy energy = impact_energy(ball, a.motion, after);
      return energy.after.total_j() / energy.before.total_j() - 1.0;
    };
    worst = std::max(worst, gain(StrongeContact{a.mu}));
    n_coulomb_creates += gain(CoulombContact{a.mu}) > 1e-14 ? 1 : 0;
  }
  // a dozen roundings of 1.1e-16 in the energies, and as many in the impulse, doubled by the square
  EXPECT_LT(worst, 5e-15);
  // the same approaches make energy under Newton's restitution: what the rule is for
  EXPECT_GT(n_coulomb_creates, n / 100);
}

TEST(Stronge, EndsAndCreatesNoEnergyWhereFrictionJamsTheContact) {
  // mu tan(offset) beyond K_zz: while the contact slips, friction drives it into the plate
  const Ball ball;
  double worst = -1.0;
  for (std::uint64_t k = 0; k < 20'000; ++k) {
    RubbingApproach a = random_rubbing_approach(k);
    a.mu *= k % 2 == 0 ? 10.0 : 1000.0;
    if (!approaches(a)) continue;
    const Motion after = collide(ball, ConstantLaw{a.eps}, StrongeContact{a.mu}, a.lever_m, a.motion).after;
    EXPECT_GT(velocity_of_contact(after, a.lever_m).z, -1e-14) << k;
    const ImpactEnergy energy = impact_energy(ball, a.motion, after);
    worst = std::max(worst, energy.after.total_j() / energy.before.total_j() - 1.0);
  }
  EXPECT_LT(worst, 5e-15);  // rounding, as above
}

TEST(Stronge, FollowsItsDefinition) {
  const Ball ball;
  int n_turning = 0;
  for (std::uint64_t k = 0; k < 150; ++k) {
    const RubbingApproach a = random_rubbing_approach(k);
    if (!approaches(a)) continue;
    constexpr int kSteps = 20'000;
    const Collision c = collide(ball, ConstantLaw{a.eps}, StrongeContact{a.mu}, a.lever_m, a.motion);
    const Followed twin = follow(ball, a, kSteps);
    // the twin's error is a step or two of its normal impulse; the rule's own is at most 2e-3 of mu P_n
    EXPECT_LT(norm(c.impulse_ns - twin.impulse), (3.0 / kSteps + 2e-3 * a.mu) * c.impulse_ns.z) << k;
    const ImpactEnergy energy = impact_energy(ball, a.motion, c.after);
    const double lost = energy.dissipated_j - energy.created_j;
    const double expected = (1.0 - a.eps * a.eps) * twin.compression_j + twin.friction_j;
    // work is impulse times some 1 m/s, so the twin's error again, against the energy before; none of the rule's own
    // here: an impulse that errs across the slip does no work to first order
    EXPECT_NEAR(lost / energy.before.total_j(), expected / energy.before.total_j(), 6.0 / kSteps) << k;
    const Vector3 t = {twin.impulse.x, twin.impulse.y, 0.0}, v = velocity_of_contact(a.motion, a.lever_m);
    n_turning += std::abs(t.x * v.y - t.y * v.x) > 0.02 * norm(t) * std::hypot(v.x, v.y) ? 1 : 0;
  }
  EXPECT_GT(n_turning, 20);  // or the slip's turning would not have been tested
}

TEST(Stronge, CentralContactHasEpsExactlyAndSlidesOrRollsAsInTextbooks) {
  const Ball ball;
  const Vector3 lever{0, 0, -ball.radius_m};
  const auto after = [&](double vx, double mu, double eps) {
    return collide(ball, ConstantLaw{eps}, StrongeContact{mu}, lever, {{vx, 0.0, -1.0}, {}}).after;
  };
  constexpr double kOfSpeeds = 1e-14;  // of speeds of 1 m/s
  EXPECT_NEAR(after(0.0, 0.3, 0.9).velocity_mps.z, 0.9, kOfSpeeds);
  EXPECT_EQ(after(0.0, 0.3, 0.9).velocity_mps.x, 0.0);
  EXPECT_NEAR(after(0.5, 0.0, 0.9).velocity_mps.x, 0.5, kOfSpeeds);
  EXPECT_NEAR(after(0.5, 0.1, 0.0).velocity_mps.z, 0.0, kOfSpeeds);
  // sliding to the end: dv_x = -mu (1 + eps) v_n, R omega = 5/2 of it; rolling: v' = 5/7 v
  EXPECT_NEAR(after(1.0, 0.1, 0.8).velocity_mps.x, 1.0 - 0.1 * 1.8, kOfSpeeds);
  EXPECT_NEAR(after(1.0, 0.1, 0.8).spin_radps.y * ball.radius_m, 2.5 * 0.18, 3.0 * kOfSpeeds);
  EXPECT_NEAR(after(0.01, 0.1, 0.8).velocity_mps.x, 5.0 / 7.0 * 0.01, kOfSpeeds);
  EXPECT_NEAR(after(0.01, 0.1, 0.8).velocity_mps.z, 0.8, kOfSpeeds);
}

TEST(Stronge, SlipThatReversesHasTheClosedFormOfThePlane) {
  // in the plane v_z is linear in p between the stop of slip and the ends: three branches, added up here by hand
  const Ball ball;
  const double r = ball.radius_m, m = mass_kg(ball), j = moment_of_inertia_kgm2(ball);
  const double rho = 0.12 * r, mu = 0.05, eps = 0.7, speed = 0.02;
  const double along = 1.0 / m + r * r / j, normal = 1.0 / m + rho * rho / j, k = rho * r / j;
  ASSERT_GT(k / along, mu);  // friction cannot hold the contact
  // slip against e: friction +mu, until it stops at p1; then with e: friction -mu
  const double p1 = speed / (mu * along + k), z1 = normal + mu * k, z2 = normal - mu * k;
  const double v1 = -1.0 + z1 * p1;
  ASSERT_LT(v1, 0.0);
  const double compression = 0.5 * p1 * (1.0 - v1) + 0.5 * v1 * v1 / z2;
  const double p = p1 - v1 / z2 + std::sqrt(2.0 * eps * eps * compression / z2);
  const Collision c = collide(ball, ConstantLaw{eps}, StrongeContact{mu}, {rho, 0, -r}, {{-speed, 0, -1.0}, {}});
  EXPECT_NEAR(c.impulse_ns.z / p, 1.0, 1e-13);  // a dozen roundings
  EXPECT_NEAR(c.impulse_ns.x / p, (p1 - (p - p1)) * mu / p, 1e-13);
}

}  // namespace
}  // namespace bouncelab::sim
