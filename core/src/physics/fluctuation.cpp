// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/fluctuation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_fluctuation(double q, const ImpactConditions& at) {
  const auto require = [](bool good, const char* what, double value, const char* range) {
    if (!good) throw InvalidArgument("fluctuation: " + (what + (" = " + std::to_string(value))) + " is not " + range);
  };
  require(q > 0.0 && q <= 0.1, "q", q, "in (0, 0.1]");
  require(at.v_mps > 0.0 && std::isfinite(at.v_mps), "speed", at.v_mps, "positive and finite [m/s]");
  require(at.eps > 0.0 && std::isfinite(at.eps), "eps", at.eps, "positive and finite");
  require(std::abs(at.v_mps * at.eps_slope_spm) < 0.5, "slope of eps", at.eps_slope_spm, "below 1/(2 v) [s/m]");
  require(at.reservoir_m2ps2 >= 0.0 && std::isfinite(at.reservoir_m2ps2), "reservoir", at.reservoir_m2ps2,
          "finite and at least 0 [m^2/s^2]");
}

double speed_factor(const ImpactConditions& at) { return 1.0 + at.v_mps * at.eps_slope_spm / (1.0 + at.eps); }

// Below: a standard normal point of the plane, with its mean at distance `a` from the middle of a disc of radius `b`.
// The square of its distance from the middle is a noncentral chi-square with 2 degrees of freedom and lambda = a^2.

/// I1(z)/I0(z), in [0, 1).
double bessel_ratio(double z) { return scaled_bessel_i(1, z) / scaled_bessel_i(0, z); }

/// Probability of a standard normal above z.
double normal_above(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

/// Probability that the point lies outside the disc (Marcum's Q function, which GSL does not have). Absolute error
/// 1e-12; where b > a and the probability is above 1e-14, relative error 1e-8.
///
/// The plane is cut into strips parallel to the offset, at distance y = b sin psi from the disc's middle: given y the
/// point lies inside where the other coordinate is between a - b cos psi and a + b cos psi. This is smooth in psi: 24
/// points of Gauss' rule reach rounding. Strips beyond y = 10 hold 1e-23.
double probability_outside_disc(double a, double b) {
  constexpr double kReach = 10.0;
  constexpr double kNormalPeak = std::numbers::inv_sqrtpi / std::numbers::sqrt2;  // density of a standard normal at 0
  static const QuadratureRule rule = gauss_legendre(24, 0.0, 1.0);
  const double end = b <= kReach ? 0.5 * std::numbers::pi : std::asin(kReach / b);
  double inside = 0.0, outside = 2.0 * normal_above(b);
  for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
    const SinCos psi = sin_cos(end * rule.nodes[k]);
    const double chord = b * psi.cos,
                 share = 2.0 * end * rule.weights[k] * chord * kNormalPeak * exp(-0.5 * square(b * psi.sin));
    const double far_tail = normal_above(a + chord);
    inside += share * (normal_above(a - chord) - far_tail);
    outside += share * (normal_above(chord - a) + far_tail);
  }
  return b > a ? outside : 1.0 - inside;
}

/// The radius for which the point lies outside with probability p in (0, 1).
double disc_radius(double a, double p) {
  constexpr double kReach = 38.0;  // 1e-316 of a normal lies beyond
  return root_between([&](double b) { return probability_outside_disc(a, b) - p; }, std::max(0.0, a - kReach),
                      a + kReach);
}

}  // namespace

Fluctuation::Fluctuation(double q, const ImpactConditions& at) : at_(at), q_(q), f_(speed_factor(at)) {
  check_fluctuation(q, at);
  const double half_tilt = 0.5 * std::sqrt(at.reservoir_m2ps2) / at.v_mps;
  top_ = square(f_ * half_tilt);
  centre_ = (f_ - 2.0 * q) * half_tilt / std::sqrt(q);
}

double Fluctuation::highest() const { return (1.0 + at_.eps) * top_; }

double Fluctuation::radius(double r) const { return std::sqrt(std::max(0.0, top_ - r / (1.0 + at_.eps)) / q_); }

double Fluctuation::log_density(double r) const {
  if (!(r <= highest())) return -kInfinity;
  const double b = radius(r);
  return -0.5 * square(b - centre_) + log(scaled_bessel_i(0, centre_ * b) / (2.0 * q_ * (1.0 + at_.eps)));
}

double Fluctuation::cdf(double r) const {
  if (std::isnan(r)) return r;
  return r < highest() ? probability_outside_disc(centre_, radius(r)) : 1.0;
}

double Fluctuation::quantile(double p) const {
  if (!(p > 0.0 && p < 1.0)) throw InvalidArgument("fluctuation: p = " + std::to_string(p) + " is not in (0, 1)");
  return (1.0 + at_.eps) * (top_ - q_ * square(disc_radius(centre_, p)));
}

double Fluctuation::draw(Random& random) const {
  const double x = centre_ + random.normal(), y = random.normal();
  return (1.0 + at_.eps) * (top_ - q_ * (x * x + y * y));
}

double Fluctuation::mean_square_offset(double r) const {
  // |t|^2 = q |a + b (cos phi, sin phi)|^2, and given b the angle phi has the density exp(-a b cos phi)/(2 pi I0(a b))
  const double a = centre_, b = radius(r);
  return q_ * (square(a - b) + 2.0 * a * b * (1.0 - bessel_ratio(a * b)));
}

double Fluctuation::kick(double r) const { return (1.0 + at_.eps + r) * at_.v_mps; }

double Fluctuation::reservoir_after(double r) const {
  const double t2 = mean_square_offset(r), p = kick(r), y = r / (1.0 + at_.eps);
  const double x = (y + t2 + y * t2) / f_;  // the contact approaches at v (1 + x)
  return std::max(0.0, at_.reservoir_m2ps2 - 2.0 * p * at_.v_mps * x + p * p * t2);
}

double FluctuationSides::log_density(double r) const {
  const double side = r < 0.0 ? below : above;
  if (r != 0.0 && !(side > 0.0)) return -kInfinity;
  return (r == 0.0 ? 0.0 : -std::abs(r) / side) - log(below + above);
}

FluctuationSides fluctuation_sides(double q, const ImpactConditions& at, double path_m2ps2) {
  check_fluctuation(q, at);
  if (!(path_m2ps2 >= 0.0 && std::isfinite(path_m2ps2)))
    throw InvalidArgument("fluctuation: path = " + std::to_string(path_m2ps2) +
                          " is not finite and at least 0 [m^2/s^2]");
  const double f = speed_factor(at), length = path_m2ps2 / square(at.v_mps);
  const double half_difference = q * (1.0 - q * (f - q) * length), product = square(f * q) * length;
  const double root = std::sqrt(square(half_difference) + product);
  // the smaller one as product over the larger: without cancellation
  const double larger = root + std::abs(half_difference);
  const double smaller = product / larger;
  const double below = half_difference >= 0.0 ? larger : smaller;
  return {(1.0 + at.eps) * below, (1.0 + at.eps) * (half_difference >= 0.0 ? smaller : larger)};
}

}  // namespace bouncelab
