// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/flight.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/experiment.hpp"

namespace bouncelab::sim {
namespace {

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
