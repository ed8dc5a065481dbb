// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"

namespace bouncelab::sim {
namespace {

TEST(BallSection, CutsTheAsperitiesThatThePlaneMeetsInProportion) {
  Ball ball;
  const double r_m = 0.1 * ball.radius_m;
  Surface surface;
  surface.asperities.push_back({{0.0, 0.0, 1.0}, r_m});     // through its centre
  surface.asperities.push_back({{0.6, 0.06, 0.798}, r_m});  // 0.06 R beside the plane: a circle of 0.08 R
  surface.asperities.push_back({{0.0, 0.2, 0.98}, r_m});    // too far from the plane
  surface.asperities.push_back({{0.0, 0.0, -1.0}, r_m});    // on the other side
  const BallSection section = section_of(ball, surface);
  EXPECT_EQ(section.n_asperities, 4u);
  EXPECT_DOUBLE_EQ(section.mean_asperity_radius_m, r_m);
  EXPECT_DOUBLE_EQ(section.half_angle_rad, kPi / 4);  // so few that a quarter of the circle cuts fewer than ten
  ASSERT_EQ(section.circles.size(), 2u);
  EXPECT_EQ(section.circles[0].angle_rad, 0.0);
  EXPECT_DOUBLE_EQ(section.circles[0].radius_m, r_m);
  EXPECT_DOUBLE_EQ(section.circles[1].angle_rad, std::atan2(0.6, 0.798));
  EXPECT_NEAR(section.circles[1].radius_m, 0.8 * r_m, 1e-12 * r_m);
}

TEST(BallSection, OfAFineSurfaceIsSoLongThatSomeTenAsperitiesAreCut) {
  const Ball ball;
  const BallSection section = section_of(ball, make_surface(ball, 100'000, ConstantRadii{1e-3}, 3));
  // Poisson of mean 10: beyond 3 to 22 once in 2,000 seeds
  EXPECT_GE(section.circles.size(), 3u);
  EXPECT_LE(section.circles.size(), 22u);
  EXPECT_LT(section.half_angle_rad, 0.4);
}

struct Moments {
  double mean = 0.0, sd = 0.0;
};
Moments radius_moments(const RadiusLaw& law, std::int64_t n) {
  const Ball ball;
  double sum = 0.0, sum2 = 0.0;
  for (const Asperity& a : make_surface(ball, n, law, 5).asperities) {
    const double r = a.radius_m / ball.radius_m * 1e3;
    sum += r;
    sum2 += r * r;
  }
  const double mean = sum / static_cast<double>(n);
  return {mean, std::sqrt(sum2 / static_cast<double>(n) - mean * mean)};
}

TEST(Surface, RadiiHaveTheMomentsOfTheirLaw) {
  constexpr std::int64_t kN = 100'000;
  const double se = 1.0 / std::sqrt(static_cast<double>(kN));
  // 5 standard errors of mean (sd/sqrt n) and of sd (sd sqrt((kurtosis-1)/4n), at most sqrt(2) sd/sqrt n here)
  const auto expect = [&](const RadiusLaw& law, double mean, double sd) {
    const Moments m = radius_moments(law, kN);
    EXPECT_NEAR(m.mean, mean, 5 * sd * se + 1e-12) << to_text(law);
    EXPECT_NEAR(m.sd, sd, 5 * std::sqrt(2.0) * sd * se + 1e-7) << to_text(law);
  };
  expect(ConstantRadii{1e-3}, 1.0, 0.0);
  expect(UniformRadii{0.5e-3, 1.5e-3}, 1.0, 1.0 / std::sqrt(12.0));
  expect(NormalRadii{1e-3, 1e-4}, 1.0, 0.1);
  expect(LognormalRadii{1e-3, 0.1}, std::exp(0.005), std::exp(0.005) * std::sqrt(std::expm1(0.01)));
  expect(ExponentialRadii{1e-3}, 1.0, 1.0);
}

TEST(Surface, DirectionsAreUniformOnTheSphere) {
  constexpr std::int64_t kN = 100'000;
  Vector3 sum;
  double zz = 0.0, xy = 0.0;
  for (const Asperity& a : make_surface(Ball{}, kN, UniformRadii{}, 5).asperities) {
    EXPECT_NEAR(norm(a.direction), 1.0, 3e-16);
    sum = sum + a.direction;
    zz += a.direction.z * a.direction.z;
    xy += a.direction.x * a.direction.y;
  }
  const double se = 1.0 / std::sqrt(static_cast<double>(kN));
  // 5 standard errors: var(u_x) = 1/3, var(u_z^2) = 4/45, var(u_x u_y) = 1/15
  EXPECT_LT(norm(sum) / kN, 5 * se);
  EXPECT_NEAR(zz / kN, 1.0 / 3, 5 * se * std::sqrt(4.0 / 45));
  EXPECT_NEAR(xy / kN, 0.0, 5 * se * std::sqrt(1.0 / 15));
}

TEST(Surface, OfFewerAsperitiesIsTheBeginningOfALargerOne) {
  const Surface few = make_surface(Ball{}, 10, NormalRadii{}, 3), many = make_surface(Ball{}, 20, NormalRadii{}, 3);
  for (std::size_t j = 0; j < 10; ++j) EXPECT_EQ(few.asperities[j].radius_m, many.asperities[j].radius_m);
}

TEST(Surface, GoesThroughItsTable) {
  const Ball ball;
  const Surface surface = make_surface(ball, 100, UniformRadii{}, 3);
  const Surface again = surface_from_table(to_table(surface), "s.csv", ball);
  for (std::size_t j = 0; j < 100; ++j) {
    EXPECT_EQ(again.asperities[j].radius_m, surface.asperities[j].radius_m);
    EXPECT_LT(norm(again.asperities[j].direction - surface.asperities[j].direction), 4e-16);  // normalised again
  }
}

TEST(Surface, BadRowsAreNamed) {
  const auto refuse = [](double ux, double radius_m) {
    Table table{{{"ux", std::vector<double>{1, ux}},
                 {"uy", std::vector<double>{0, 0}},
                 {"uz", std::vector<double>{0, 0}},
                 {"radius_m", std::vector<double>{1e-6, radius_m}}}};
    const std::string message = test::refusal<FileError>([&] { surface_from_table(table, "s.csv", Ball{}); });
    EXPECT_NE(message.find("row 2"), std::string::npos) << message << ": " << ux << ", " << radius_m;
  };
  refuse(0.0, 1e-6);
  refuse(NAN, 1e-6);
  refuse(INFINITY, 1e-6);
  refuse(1.0, 0.0);
  refuse(1.0, -1e-6);
  refuse(1.0, NAN);
  refuse(1.0, 3e-3);  // as large as the ball
}

TEST(RadiusLaw, ReadsWhatItWrites) {
  for (const char* text :
       {"constant:0.001", "uniform:5e-04,0.0015", "normal:0.001,1e-04", "lognormal:0.002,0.3", "exponential:0.001"})
    EXPECT_EQ(to_text(radius_law_from_text(text)), text);
  EXPECT_EQ(to_text(radius_law_from_text("uniform")), to_text(RadiusLaw{}));
}

TEST(RadiusLaw, RefusesWhatItCannotRead) {
  for (const char* text : {"", "gauss", "uniform:1e-3", "uniform:1e-3,x", "uniform:2e-3,1e-3", "constant:0",
                           "constant:-1e-3", "constant:1.5", "exponential:nan", "normal:1e-3,0"})
    EXPECT_THROW(radius_law_from_text(text), InvalidArgument) << text;
  EXPECT_THROW(make_surface(Ball{}, -1, UniformRadii{}, 1), InvalidArgument);
  EXPECT_THROW(make_surface(Ball{}, 100'000, ExponentialRadii{0.5}, 1), InvalidArgument);  // some reach R
}

}  // namespace
}  // namespace bouncelab::sim
