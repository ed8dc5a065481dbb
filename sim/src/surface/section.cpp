// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/section.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::sim {

BallSection section_of(const Ball& ball, const Surface& surface) {
  constexpr double kCut = 10.0;  // told apart at the width of a page
  BallSection section{ball.radius_m, surface.asperities.size(), 0.0, kPi / 4, {}};
  if (surface.asperities.empty()) return section;
  double sum_m = 0.0;
  for (const Asperity& a : surface.asperities) sum_m += a.radius_m;
  section.mean_asperity_radius_m = sum_m / static_cast<double>(surface.asperities.size());
  section.half_angle_rad = std::min(kPi / 4, kPi * kCut * ball.radius_m / sum_m);
  for (const Asperity& a : surface.asperities) {
    const double square_m2 = square(a.radius_m) - square(a.direction.y * ball.radius_m);
    if (!(square_m2 > 0.0)) continue;  // nearly all
    const double angle_rad = std::atan2(a.direction.x, a.direction.z);
    if (std::abs(angle_rad) <= section.half_angle_rad) section.circles.push_back({angle_rad, std::sqrt(square_m2)});
  }
  std::sort(section.circles.begin(), section.circles.end(),
            [](const SectionCircle& a, const SectionCircle& b) { return a.angle_rad < b.angle_rad; });
  return section;
}

}  // namespace bouncelab::sim
