// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/offset_disc.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/quadrature.hpp"

namespace bouncelab {
namespace {

constexpr double kNormalPeak = std::numbers::inv_sqrtpi / std::numbers::sqrt2;  // density of a standard normal at 0

/// exp(-z) I_n(z), n = 0 or 1: the power series below, the asymptotic one above 30, where its smallest term is of order
/// exp(-2 z). Source: Olver et al., NIST Handbook of Mathematical Functions (2010), 10.25.2 and 10.40.1.
double scaled_bessel(int n, double z) {
  constexpr double kSwitch = 30.0;
  double term = 1.0, sum = 1.0;
  if (z < kSwitch) {
    const double quarter = 0.25 * z * z;
    for (int k = 1; term > 1e-17 * sum; ++k) sum += term *= quarter / (k * (k + n));
    return exp(-z) * sum * (n == 0 ? 1.0 : 0.5 * z);
  }
  for (int k = 1; k < 30 && std::abs(term) > 1e-17; ++k)
    sum += term *= (square(2.0 * k - 1.0) - 4.0 * n) / (8.0 * k * z);
  return sum * kNormalPeak / std::sqrt(z);
}

/// Probability of a standard normal above z.
double normal_above(double z) { return 0.5 * erfc(z / std::numbers::sqrt2); }

struct Probability {
  double inside, outside;
};

constexpr std::size_t kStrips = 24;
using OfStrips = std::array<double, kStrips>;

/// Middles of the strips by the angle psi from 0 to `end`, and their widths.
struct Strips {
  explicit Strips(double end) {
    static const QuadratureRule rule = gauss_legendre(kStrips, 0.0, 1.0);
    for (std::size_t k = 0; k < kStrips; ++k) {
      const SinCos psi = sin_cos(end * rule.nodes[k]);
      sin[k] = psi.sin;
      cos[k] = psi.cos;
      width[k] = end * rule.weights[k];
    }
  }
  OfStrips sin, cos, width;
};

/// Strips of the plane parallel to the offset, at distance y = b sin psi from the disc's middle: given y the point lies
/// inside where the other coordinate is between a - b cos psi and a + b cos psi. Smooth in psi: 24 points of Gauss'
/// rule reach rounding. Strips beyond y = 10 hold 1e-23. All strips side by side: exponentials and error functions are
/// what this takes.
Probability offset_disc(double a, double b) {
  constexpr double kReach = 10.0;
  static const Strips of_quarter(0.5 * std::numbers::pi);
  const auto strips = [&] {
    return b <= kReach ? of_quarter : Strips(atan2(kReach, std::sqrt(b * b - kReach * kReach)));
  }();
  OfStrips weight, nearest, beyond;
  for (std::size_t k = 0; k < kStrips; ++k) {
    const double chord = b * strips.cos[k];
    weight[k] = -0.5 * square(b * strips.sin[k]);
    nearest[k] = std::abs(a - chord) / std::numbers::sqrt2;
    beyond[k] = (a + chord) / std::numbers::sqrt2;
  }
  exp_each(weight);
  erfc_each(nearest);
  erfc_each(beyond);
  Probability p{0.0, 2.0 * normal_above(b)};
  for (std::size_t k = 0; k < kStrips; ++k) {
    const double chord = b * strips.cos[k];
    const double share = 2.0 * strips.width[k] * chord * kNormalPeak * weight[k];
    const double tail = 0.5 * nearest[k], far_tail = 0.5 * beyond[k];
    p.inside += share * ((a > chord ? tail : 1.0 - tail) - far_tail);
    p.outside += share * ((a > chord ? 1.0 - tail : tail) + far_tail);
  }
  return p;
}

}  // namespace

double scaled_bessel_i0(double z) { return scaled_bessel(0, z); }
double bessel_ratio(double z) { return scaled_bessel(1, z) / scaled_bessel(0, z); }

double cosine_variance(double z) {
  if (z < 1e-8) return 0.5;
  if (z > 3e3) return (0.5 + 0.25 / z) / (z * z);  // the first two terms of what cancels below
  const double ratio = bessel_ratio(z);
  return 1.0 - ratio / z - ratio * ratio;
}

double probability_outside_disc(double a, double b) {
  const Probability p = offset_disc(a, b);
  return b > a ? p.outside : 1.0 - p.inside;
}

double disc_radius(double a, double p) {
  constexpr double kReach = 38.0;  // 1e-316 of a normal lies beyond
  double lo = std::max(0.0, a - kReach), hi = a + kReach;
  double b = std::max(a, 1.0);
  for (int iteration = 0; iteration < 200 && hi - lo > 1e-15 * hi; ++iteration) {
    const double outside = probability_outside_disc(a, b);
    (outside > p ? lo : hi) = b;
    // Newton's step in ln p, which is concave in b; where it leaves the bracket, its middle
    const double density = b * exp(-0.5 * square(b - a)) * scaled_bessel_i0(a * b);
    const double next = b + (density > 0.0 ? outside / density * log(outside / p) : kReach);
    if (std::abs(next - b) <= 1e-15 * b) break;
    b = next > lo && next < hi ? next : 0.5 * (lo + hi);
  }
  return b;
}

}  // namespace bouncelab
