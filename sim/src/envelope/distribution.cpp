// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/distribution.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {
namespace {

/// Range of patches along an edge of the cube, [first, last].
struct PatchRange {
  int first = 0, last = -1;
};

/// Patches whose regions a cap around u meets along one coordinate of a face: its outline is touched by the planes
/// y = a x with (u.y - a u.x)^2 = s^2 (1 + a^2), s the sine of the cap's half-angle.
PatchRange patches_met(double along, double normal, double s, int n_side) {
  const double below = normal * normal - s * s;
  if (normal <= s || below < 1e-6) return {0, n_side - 1};
  const double spread = s * std::sqrt(std::max(0.0, below + along * along));
  const double lo = (normal * along - spread) / below, hi = (normal * along + spread) / below;
  const double margin = kRegionMargin - 1.0;
  const auto index = [n_side](double a, double shift) {
    return static_cast<int>(std::floor(std::clamp((a + 1.0) * 0.5 * n_side + shift, -1.0, n_side + 1.0)));
  };
  return {std::max(0, index(lo, -0.5 * margin)), std::min(n_side - 1, index(hi, 0.5 * margin))};
}

/// Does a cap around u stay outside the regions of all patches of a face, by the plane through the ball's centre and
/// the region's outermost edge? Where this is not sure it says no.
bool is_surely_outside(double along, double normal, double s, double outermost) {
  return std::abs(along) - outermost * normal > (s + 1e-6) * std::sqrt(1.0 + outermost * outermost) &&
         normal > s + 1e-3;
}

/// Calls with every patch in whose region an asperity rises above the envelope's least elevation (and a few more).
/// @param rise  of the asperity above that elevation
template <class Function>
void for_each_patch(const Asperity& asperity, double rise, int n_side, const Function& function) {
  if (rise < 0.0) return;
  // |n - u| = sqrt(2 rise) = 2 sin(angle / 2)
  const double s = std::sqrt(2.0 * rise * (1.0 - 0.5 * rise));
  const double outermost = 1.0 + (kRegionMargin - 1.0) / n_side;
  for (int face = 0; face < 6; ++face) {
    const Vector3 u = to_face(face, asperity.direction);
    if (u.x < 0.4 - s) continue;  // no region reaches farther from its face's centre than this
    if (is_surely_outside(u.y, u.x, s, outermost) || is_surely_outside(u.z, u.x, s, outermost)) continue;
    const PatchRange a = patches_met(u.y, u.x, s, n_side), b = patches_met(u.z, u.x, s, n_side);
    for (int ib = b.first; ib <= b.last; ++ib)
      for (int ia = a.first; ia <= a.last; ++ia) function(patch_index(face, ia, ib, n_side));
  }
}

}  // namespace

Distribution distribute(const Ball& ball, const Surface& surface, int n_side, double least_elevation) {
  Distribution d;
  d.begin.assign(patch_index(6, 0, 0, n_side) + 1, 0);
  const auto visit = [&](const auto& function) {
    for (std::size_t j = 0; j < surface.asperities.size(); ++j)
      for_each_patch(surface.asperities[j], surface.asperities[j].radius_m / ball.radius_m - least_elevation, n_side,
                     [&](std::size_t patch) { function(patch, static_cast<std::uint32_t>(j)); });
  };
  visit([&](std::size_t patch, std::uint32_t) { ++d.begin[patch + 1]; });
  std::partial_sum(d.begin.begin(), d.begin.end(), d.begin.begin());
  d.asperities.resize(d.begin.back());
  std::vector<std::size_t> next(d.begin.begin(), d.begin.end() - 1);
  visit([&](std::size_t patch, std::uint32_t j) { d.asperities[next[patch]++] = j; });
  return d;
}

}  // namespace bouncelab::sim
