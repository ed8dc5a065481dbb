// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace bouncelab::fit {

inline constexpr double kSqrt2Pi = 2.50662827463100050242;
inline constexpr double kLogSqrt2Pi = 0.91893853320467274178;
inline constexpr double kSqrtHalfPi = 1.25331413731550025121;
inline constexpr double kInvSqrt2 = 0.70710678118654752440;
/// exp(-u^2/2) is below 1e-17 from here on: the other side of the peak and the normal no longer matter.
inline constexpr double kFar = 8.8;
inline constexpr double kVanished = -700.0;  ///< exp() of less is 0

/// exp(x^2) erfc(x), x >= 0; relative error below 1e-15.
/// Source: Cody, Math. Comp. 23, 631 (1969), doi:10.1090/S0025-5718-1969-0247736-4.
double scaled_erfc(double x);

/// Mills ratio of the normal, R(u) = (1 - Phi(u)) / phi(u), u >= 0.
double mills_ratio(double u);

/// Asymmetric Laplace of scales b_below, b_above about 0, convolved with a normal of standard deviation tau:
///
///   f(d) = (T1 + T2) / (b_below + b_above),   a = 1/b_above, c = 1/b_below, z = d/tau,
///   T1 = phi(z) R(a tau - z),   T2 = phi(z) R(c tau + z)
///
/// Logarithm and its derivatives; exact in both tails and for tau = 0, where the derivative at the kink is the mean
/// of those on its two sides. Source: Reed & Jorgensen, Commun. Stat. Theory Methods 33, 1733 (2004),
/// doi:10.1081/STA-120037438.
struct NormalLaplace {
  /// The density is factor exp(exponent): of many, one logarithm of the product of the factors serves.
  double exponent = 0.0, factor = 1.0;
  double d_location = 0.0;   ///< by the peak, i.e. -d/dd
  double d_log_below = 0.0;  ///< by log b_below
  double d_log_above = 0.0;  ///< by log b_above
  double d_log_tau = 0.0;    ///< by log tau, from f + (b_above - b_below) f' - b_above b_below f'' = phi(z)/tau
  double log_density() const;
};
/// @param b_below, b_above  > 0
/// @param tau               >= 0
NormalLaplace normal_laplace(double d, double b_below, double b_above, double tau);

/// The two sides, with what the density needs of them.
struct LaplaceSides {
  double b_below = 1.0, b_above = 1.0;
  double inverse_below = 1.0, inverse_above = 1.0;
  double p_above = 0.5;        ///< probability of the upper side
  double inverse_width = 0.5;  ///< 1 / (b_below + b_above)
};
LaplaceSides laplace_sides(double b_below, double b_above);

/// The same density, and a constant beside it, where the sides or the timing error serve many samples.
/// @param inverse_tau  1 / tau, tau > 0
/// @param background   added to the density, >= 0
NormalLaplace normal_laplace(double d, const LaplaceSides& sides, double tau, double inverse_tau,
                             double background = 0.0);

/// Distribution function of the same.
double normal_laplace_cdf(double d, double b_below, double b_above, double tau);

/// Expected Fisher information of one observation on (location, log b_below, log b_above, log tau): E[score score^T],
/// by Gauss-Legendre quadrature, relative error below 1e-5; closed form for tau = 0.
Eigen::Matrix4d normal_laplace_information(double b_below, double b_above, double tau);

}  // namespace bouncelab::fit
