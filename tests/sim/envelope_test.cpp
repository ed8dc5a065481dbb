// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/envelope.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "bouncelab/core/random.hpp"

namespace bouncelab::sim {
namespace {

Vector3 random_direction(std::uint64_t k) {
  Random random(9, RandomStream::test, k);
  return normalized(Vector3{random.normal(), random.normal(), random.normal()});
}

/// The highest of all, one by one.
Envelope::Support support_by_brute_force(const Ball& ball, const Surface& surface, Vector3 n) {
  Envelope::Support support;
  for (std::size_t j = 0; j < surface.asperities.size(); ++j) {
    const Asperity& a = surface.asperities[j];
    const double elevation = a.radius_m / ball.radius_m - 0.5 * norm2(n - a.direction);
    if (elevation > support.elevation) support = {elevation, static_cast<std::int64_t>(j)};
  }
  return support;
}

void expect_support_by_brute_force(const Surface& surface, std::uint64_t n_directions) {
  const Ball ball;
  const Envelope envelope(ball, surface);
  for (std::uint64_t k = 0; k < n_directions; ++k) {
    const Vector3 n = random_direction(k);
    const Envelope::Support ours = envelope.support(n), twin = support_by_brute_force(ball, surface, n);
    ASSERT_EQ(ours.asperity, twin.asperity) << "direction " << k;
    ASSERT_EQ(ours.elevation, twin.elevation) << "direction " << k;
  }
}

TEST(Envelope, SupportIsThatOfBruteForceForEveryRadiusLawAndNumber) {
  for (const RadiusLaw& law : {RadiusLaw{ConstantRadii{}}, RadiusLaw{UniformRadii{}}, RadiusLaw{NormalRadii{}},
                               RadiusLaw{LognormalRadii{1e-3, 1.0}}, RadiusLaw{ExponentialRadii{}}})
    for (const std::int64_t n_asperities : {1, 10, 1'000, 30'000}) {
      SCOPED_TRACE(to_text(law) + ", N = " + std::to_string(n_asperities));
      expect_support_by_brute_force(make_surface(Ball{}, n_asperities, law, 21), 2'000);
    }
}

TEST(Envelope, SupportIsThatOfBruteForceOnTheEdgesAndCornersOfTheCube) {
  const Ball ball;
  const Surface surface = make_surface(ball, 30'000, UniformRadii{}, 21);
  const Envelope envelope(ball, surface);
  for (int k = 0; k < 1'000; ++k) {
    const double a = -1.0 + 0.002 * k;
    for (const Vector3& x : {Vector3{1, 1, a}, Vector3{a, -1, 1}, Vector3{-1, a, -1}})
      ASSERT_EQ(envelope.support(normalized(x)).asperity,
                support_by_brute_force(ball, surface, normalized(x)).asperity);
  }
}

TEST(Envelope, SupportIsThatOfBruteForceWhereASurfaceHasHolesAndTwins) {
  // a measured surface may cover a part of the ball only, or name an asperity twice (then the first counts)
  Surface surface;
  for (const Asperity& a : make_surface(Ball{}, 5'000, UniformRadii{}, 22).asperities)
    if (a.direction.z > 0.3) surface.asperities.insert(surface.asperities.end(), 3, a);
  expect_support_by_brute_force(surface, 2'000);
}

TEST(Envelope, SupportIsThatOfBruteForceWhereAllAsperitiesAreInASmallPart) {
  // 300,000 within one patch: neighbours lie farther apart in its sites than the short indices of a list reach
  const Ball ball;
  Surface surface;
  for (Asperity a : make_surface(ball, 300'000, ConstantRadii{1e-5}, 24).asperities) {
    a.direction = normalized(Vector3{0.125, 0.125, 1.0} + 0.1 * a.direction);
    surface.asperities.push_back(a);
  }
  const Envelope envelope(ball, surface);
  for (std::uint64_t k = 0; k < 300; ++k) {
    const Vector3 n = surface.asperities[997 * k].direction, beside = normalized(n + 1e-3 * random_direction(k));
    ASSERT_EQ(envelope.support(beside).asperity, support_by_brute_force(ball, surface, beside).asperity);
  }
}

TEST(Envelope, OneTowerAmongAMillionLengthensNoListAndTakesNoRoom) {
  // the structure that makes the search constant in time, counted: lists to look through, and the size of the index
  const Ball ball;
  Surface surface = make_surface(ball, 1'000'000, UniformRadii{}, 23);
  const Envelope plain(ball, surface);
  surface.asperities[123'456].radius_m = 0.05 * ball.radius_m;
  const Envelope towered(ball, surface);
  const Vector3 tower = surface.asperities[123'456].direction;
  std::size_t longest = 0;
  std::int64_t n_same = 0, n_away = 0;
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    const Vector3 n = random_direction(k);
    const Envelope::Leaf cell = towered.leaf_at(n);
    longest = std::max(longest, cell.list.size());
    // it reaches as far as |n - u| = sqrt(2 x 0.05) = 0.32; beyond that, and a patch of 0.3, nothing changes
    if (norm(n - tower) < 0.7) continue;
    ++n_away;
    n_same += plain.leaf_at(n).list.size() == cell.list.size() ? 1 : 0;
  }
  EXPECT_LE(longest, 16U);
  EXPECT_EQ(n_same, n_away);
  EXPECT_EQ(towered.support(tower).asperity, 123'456);
}

}  // namespace
}  // namespace bouncelab::sim
