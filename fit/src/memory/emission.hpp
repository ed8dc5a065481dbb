// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ceres/jet.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"
#include "memory/chains.hpp"

namespace bouncelab::fit {

/// The law's coordinates at most, log q, keep, log M, slip; then what is tested.
inline constexpr int kMostMemoryLawParameters = 5, kTestedParameters = 2;

/// A number that carries its derivatives (automatic differentiation). Of one size: each size is compiled anew.
using Jet = ceres::Jet<double, kMostMemoryLawParameters + 3 + static_cast<int>(kSlipTimes) + kTestedParameters>;

inline double number_of(double x) { return x; }
inline double number_of(const Jet& x) { return x.a; }

template <class T>
T square_of(const T& x) {
  return x * x;
}

/// max(x, 0) with its corner rounded over +-width: (x + sqrt(x^2 + width^2)) / 2, without cancellation below 0.
/// @param square  of the width, > 0
template <class T>
T rounded_positive(const T& x, const T& square) {
  using std::sqrt;
  const T r = sqrt(x * x + square);
  if (number_of(x) >= 0.0) return 0.5 * (x + r);
  return 0.5 * square / (r - x);
}

/// The law at one impact.
template <class T>
struct LawAt {
  T eps;
  T slope;  ///< d eps / d v [s/m]
};

/// What all impacts have in common.
template <class T>
struct MemoryParameters {
  T q;        ///< variance of the contacts' offset, per component (docs/physics.md)
  T keep;     ///< share of the reservoir that outlasts a bounce, long after the release
  T release;  ///< mean reservoir at the release; less than 0 where first ones are less than impacts make [m^2/s^2]
  /// Of the logarithm of the reservoir: what slip at the contact takes soon after a release, by each decay, in all.
  std::array<T, kSlipTimes> slip;
  /// What the model says has one value, to be tested by the derivative there.
  T ratio;  ///< 1; of the mean of |t|^2 to 2 q: both effects of the offset agree
  T power;  ///< 0; d log q / d log v: the ball is as rough at every speed
};

/// Share of the reservoir that outlasts an impact. Until the contact of a ball that was released with spin rolls,
/// friction turns spin into sideways motion and heat, unseen by vertical speeds.
template <class T>
T kept(const MemoryParameters<T>& p, const ChainImpact& m) {
  T lost(0.0);
  for (std::size_t j = 0; j < kSlipTimes; ++j) lost += p.slip[j] * m.soon[j];
  return p.keep * exp(T(-lost));
}

/// One impact of a ball whose reservoir w is known to within a normal error: v r plus the normal error of what was
/// measured, in m/s. Without error v r = (1 + e)(f t_x sqrt(w) - v |t|^2), t two components of variance q.
template <class T>
struct EmissionInput {
  T y;                   ///< measured speed after it less eps(v) v [m/s]
  T noise_mean;          ///< of the measurement's error in y [m/s]
  T noise_variance;      ///< [m^2/s^2]
  T reservoir;           ///< mean of w, > 0 [m^2/s^2]
  T reservoir_variance;  ///< [m^4/s^4]
  T covariance;          ///< of the error in y with w [m^3/s^3]
  T a;                   ///< variance of v r by w: q (1 + e)^2 f^2
  T b;                   ///< mean of (1 + e) v |t|^2: 2 q (1 + e) v [m/s]
};

/// The density of y, factor exp(exponent), and derivatives of its logarithm by the means of error and reservoir.
template <class T>
struct Emission {
  T exponent, factor;
  T by_noise;            ///< d / d noise_mean
  T by_reservoir;        ///< d / d reservoir
  T curvature_by_noise;  ///< second derivatives
  T curvature_by_reservoir;
  T variance;                ///< second derivative of the cumulant generating function at the saddlepoint
  double saddlepoint = 0.0;  ///< s [s/m]

  T log_density() const { return exponent + log(factor); }
};

/// Cumulant generating function of y and its derivatives by s: given w
///
///   K(s) = A w - log(1 + b s) + mu s + S s^2 / 2,   A(s) = a s^2 / (2 (1 + b s))
///
/// and over a normal w of variance P and covariance C with the error + A^2 P / 2 + C s A.
template <class T>
struct Cumulants {
  T rest, u;  ///< K = rest - log u
  T k1, k2, k3, k4;
  T a1, a2, a0;  ///< A and its derivatives

  Cumulants(const EmissionInput<T>& in, const T& s) : u(1.0 + in.b * s) {
    const T inverse = 1.0 / u, b = in.b * inverse, b2 = b * b;
    const T inverse3 = inverse * inverse * inverse;
    a0 = 0.5 * in.a * s * s * inverse;
    a1 = 0.5 * in.a * s * (1.0 + u) * inverse * inverse;
    a2 = in.a * inverse3;
    const T a3 = -3.0 * a2 * b, a4 = -4.0 * a3 * b;
    const T& m = in.reservoir;
    const T& p = in.reservoir_variance;
    const T& c = in.covariance;
    rest = a0 * (m + 0.5 * p * a0 + c * s) + s * (in.noise_mean + 0.5 * in.noise_variance * s);
    k1 = a1 * (m + p * a0 + c * s) + c * a0 - b + in.noise_mean + in.noise_variance * s;
    k2 = a2 * (m + p * a0 + c * s) + a1 * (p * a1 + 2.0 * c) + b2 + in.noise_variance;
    k3 = a3 * (m + p * a0 + c * s) + 3.0 * a2 * (p * a1 + c) - 2.0 * b2 * b;
    k4 = a4 * (m + p * a0 + c * s) + 4.0 * a3 * (p * a1 + c) + 3.0 * p * a2 * a2 + 6.0 * b2 * b2;
  }
};

inline EmissionInput<double> values_of(const EmissionInput<Jet>& in) {
  return {in.y.a, in.noise_mean.a, in.noise_variance.a, in.reservoir.a, in.reservoir_variance.a, in.covariance.a,
          in.a.a, in.b.a};
}
inline EmissionInput<double> values_of(const EmissionInput<double>& in) { return in; }

struct Saddlepoint {
  double s, curvature;  ///< K''(s)
};
/// Solves K'(s) = y: K' rises from -infinity at s = -1/b. Newton's steps, kept inside what is known to enclose it.
inline Saddlepoint saddlepoint(const EmissionInput<double>& in) {
  const double edge = -1.0 / in.b;
  double lo = edge, hi = HUGE_VAL;
  const double k2 = in.a * in.reservoir + in.b * in.b + in.noise_variance;
  double s = (in.y - in.noise_mean + in.b) / k2;
  if (s <= 0.7 * edge) s = 0.7 * edge;
  double curvature = k2;
  for (int i = 0; i < 100; ++i) {
    const Cumulants<double> at(in, s);
    const double miss = at.k1 - in.y, slope = at.k2;
    (miss > 0.0 ? hi : lo) = s;
    double next = slope > 0.0 ? s - miss / slope : s;
    if (!(next > lo && next < hi) || !(slope > 0.0)) next = std::isinf(hi) ? s + 1.0 / std::sqrt(k2) : 0.5 * (lo + hi);
    const double step = next - s;
    s = next;
    curvature = slope;
    // what is left is the square of that, and emission() makes one more step
    if (step * step * std::abs(slope) < 1e-9) break;
  }
  return {s, curvature};
}

/// Saddlepoint approximation with its second-order term in the exponent: within .3 % of the density also where that is
/// an exponential (w = 0). Source: Daniels, Ann. Math. Stat. 25, 631 (1954), doi:10.1214/aoms/1177728652.
template <class T>
Emission<T> emission(const EmissionInput<T>& in) {
  using std::sqrt;
  Emission<T> out;
  const Saddlepoint found = saddlepoint(values_of(in));
  // one step with derivatives: of the solution by all it depends on
  const T s = found.s - (Cumulants<T>(in, T(found.s)).k1 - in.y) / found.curvature;
  out.saddlepoint = number_of(s);
  const Cumulants<T> c(in, s);
  const T inverse = 1.0 / c.k2, skew = c.k3 * inverse * inverse;
  constexpr double kInverseRootTwoPi = 0.3989422804014327;
  out.exponent = c.rest - s * in.y + 0.125 * c.k4 * inverse * inverse - (5.0 / 24.0) * skew * skew * c.k2;
  out.factor = kInverseRootTwoPi / (c.u * sqrt(c.k2));
  out.by_noise = s + 0.5 * skew;
  out.curvature_by_noise = -inverse;
  // s moves by -A' / K'' with the reservoir
  out.by_reservoir = c.a0 - 0.5 * inverse * (c.a2 - c.k3 * c.a1 * inverse);
  const T wide = c.a2 * inverse;
  out.curvature_by_reservoir = 0.5 * wide * wide - c.a1 * c.a1 * inverse;
  out.variance = c.k2;
  return out;
}

/// Probability of less than y: Lugannani & Rice, Adv. Appl. Prob. 12, 475 (1980), doi:10.2307/1426607.
template <class T>
double probability_below(const EmissionInput<T>& in, const Emission<T>& em) {
  const EmissionInput<double> x = values_of(in);
  const Cumulants<double> c(x, em.saddlepoint), zero(x, 0.0);
  const double s = em.saddlepoint, fall = 2.0 * (s * x.y - c.rest + log(c.u));
  const double w = (s < 0.0 ? -1.0 : 1.0) * std::sqrt(std::max(0.0, fall)), u = s * std::sqrt(c.k2);
  const double below = 0.5 * erfc(-w * 0.70710678118654752);
  const double density = 0.3989422804014327 * exp(-0.5 * w * w);
  // 1/w - 1/u is a small difference near the mean: its limit there
  const double near = std::abs(u) < 1e-3 ? -zero.k3 / (6.0 * power(std::sqrt(zero.k2), 3)) : 1.0 / w - 1.0 / u;
  return std::clamp(below + density * near, 0.0, 1.0);
}

/// Mean of |t|^2 given v r and w: t lies on a circle about the point f sqrt(w)/(2 v), by von Mises' density.
/// @param reach   (f / (2 v))^2 [s^2/m^2]
/// @param y_by_v  y / (v (1 + e))
template <class T>
T mean_offset_square(const T& w, const T& reach, const T& y_by_v, const T& q) {
  using std::sqrt;
  const T centre = sqrt(reach * w);
  const T radius = sqrt(rounded_positive<T>(reach * w - y_by_v, square_of(1e-2 * q)));
  const T kappa = centre * radius / q;
  const T r = sqrt(kappa * kappa + 2.25);
  // 1 - I1/I0, to 3 %: Amos, Math. Comp. 28, 239 (1974), doi:10.1090/S0025-5718-1974-0333287-7
  const T rest = (0.5 + 2.25 / (r + kappa)) / (0.5 + r);
  return square_of(centre - radius) + 2.0 * centre * radius * rest;
}

}  // namespace bouncelab::fit
