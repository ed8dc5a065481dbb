// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/sim/theory.hpp"
#include "surface/radius_law.hpp"

namespace bouncelab::sim {
namespace {

/// int_E^inf (r - E)^k p(r) dr for k = 1, 2.
struct Excess {
  double first = 0.0, second = 0.0;
};

double density_of_normal(double z) { return exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2; }
double normal_beyond(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

Excess excess(const ConstantRadii& law, double e) {
  const double h = std::max(0.0, law.radius - e);
  return {h, h * h};
}

Excess excess(const UniformRadii& law, double e) {
  const double width = law.hi - law.lo;
  if (e < law.lo) {
    const double h = 0.5 * (law.lo + law.hi) - e;
    return {h, h * h + width * width / 12.0};
  }
  const double h = std::max(0.0, law.hi - e);
  return {h * h / (2.0 * width), h * h * h / (3.0 * width)};
}

Excess excess(const NormalRadii& law, double e) {
  const double z = (e - law.mean) / law.sd, above = normal_beyond(z), density = density_of_normal(z);
  const double share = normal_beyond(-law.mean / law.sd);  // not truncated
  return {law.sd * (density - z * above) / share, square(law.sd) * ((1.0 + z * z) * above - z * density) / share};
}

Excess excess(const LognormalRadii& law, double e) {
  const double s = law.sigma, d = e > 0.0 ? log(e / law.median) / s : -1e3;
  const double zeroth = normal_beyond(d), first = law.median * exp(0.5 * s * s) * normal_beyond(d - s);
  const double second = square(law.median) * exp(2.0 * s * s) * normal_beyond(d - 2.0 * s);
  return {first - e * zeroth, second - 2.0 * e * first + e * e * zeroth};
}

Excess excess(const ExponentialRadii& law, double e) {
  const double above = exp(-e / law.mean);
  return {law.mean * above, 2.0 * square(law.mean) * above};
}

/// The E >= 0 at which the decreasing f falls through `value`; 0 where it is below from the start.
template <class Function>
double falls_through(const Function& f, double value) {
  if (f(0.0) <= value) return 0.0;
  double hi = 1e-9;
  while (f(hi) > value) hi *= 2.0;
  return root_between([&](double e) { return f(e) - value; }, 0.0, hi);
}

ContactOffset offset_of(double mean_square, double mean_fourth, double smooth_share) {
  return {0.5 * mean_square, mean_square > 0.0 ? mean_fourth / square(mean_square) : 0.0, smooth_share};
}

}  // namespace

ContactOffset contact_offset(const RadiusLaw& law, double n_asperities) {
  validate(law);
  if (!(n_asperities > 0.0 && n_asperities < 1e300))
    throw InvalidArgument("contact offset: " + std::to_string(n_asperities) + " asperities; must be positive");
  const auto at = [&](double e) { return std::visit([e](const auto& l) { return excess(l, e); }, law); };
  const auto lambda = [&](double e) { return 0.5 * n_asperities * at(e).first; };
  // contacts lower than `begin` have probability exp(-40), higher than `end` 1e-14
  const double begin = falls_through(lambda, 40.0), end = falls_through(lambda, 1e-14);
  const double kink = std::holds_alternative<UniformRadii>(law) ? std::get<UniformRadii>(law).lo : begin;
  constexpr int kPieces = 200;
  static const QuadratureRule rule = gauss_legendre(12, 0.0, 1.0 / kPieces);
  double mean_square = 0.0, mean_fourth = 0.0;
  const double middle = std::clamp(kink, begin, end);
  for (const auto& [from, to] : {std::pair{begin, middle}, std::pair{middle, end}}) {
    if (!(from < to)) continue;
    for (int k = 0; k < kPieces; ++k) {
      // cubes: short pieces where exp(-Lambda) begins, long ones in the tail of lognormal radii
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double x = static_cast<double>(k) / kPieces + rule.nodes[i];
        const Excess h = at(from + (to - from) * x * x * x);
        const double weight = 3.0 * x * x * (to - from) * rule.weights[i] * exp(-0.5 * n_asperities * h.first);
        mean_square += weight * n_asperities * h.first;
        mean_fourth += weight * 2.0 * n_asperities * h.second;
      }
    }
  }
  return offset_of(mean_square, mean_fourth, exp(-lambda(0.0)));
}

ContactOffset contact_offset(const Surface& surface, const Envelope& envelope, std::int64_t n_directions) {
  if (n_directions < 1) throw InvalidArgument("contact offset: " + std::to_string(n_directions) + " directions");
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0)), n = static_cast<double>(n_directions);
  double mean_square = 0.0, mean_fourth = 0.0, smooth = 0.0;
  for (std::int64_t k = 0; k < n_directions; ++k) {
    const double z = 1.0 - (2.0 * static_cast<double>(k) + 1.0) / n, s = std::sqrt((1.0 - z) * (1.0 + z));
    const SinCos azimuth = sin_cos(golden_angle * static_cast<double>(k));
    const Vector3 down = normalized(Vector3{s * azimuth.cos, s * azimuth.sin, z});
    const std::int64_t asperity = envelope.support(down).asperity;
    if (asperity < 0) {
      smooth += 1.0 / n;
      continue;
    }
    const double square_offset = norm2(cross(surface.asperities[static_cast<std::size_t>(asperity)].direction, down));
    mean_square += square_offset / n;
    mean_fourth += square(square_offset) / n;
  }
  return offset_of(mean_square, mean_fourth, smooth);
}

}  // namespace bouncelab::sim
