// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/random.hpp"

namespace bouncelab {

// The coefficient of restitution of a rough ball at one impact, given what its earlier impacts have stored in spin and
// sideways motion. docs/physics.md, section 7, derives all that stands here.
//
// A ball that touches the plate with an asperity beside its lowest point turns vertical motion into spin and sideways
// motion, the reservoir, and back. Of the ball one number matters,
//
//   q = c s2,   s2: variance of each component of the contact's tangential offset over the ball's radius;
//               c = 1/(1 + J/(m R^2)) without slip (5/7 for a solid ball), m R^2/J without friction (5/2),
//
// and of its past the reservoir w = |u|^2/c [m^2/s^2], where the contact approaches at v + u . theta, theta its
// offset over R (without slip u is the speed sideways). v^2 + w is twice the kinetic energy per mass that impacts
// exchange. A ball released at rest has w = 0.

/// What an impact finds.
struct ImpactConditions {
  double v_mps = 0.0;            ///< normal speed of the centre before, > 0
  double eps = 0.0;              ///< eps(v), > 0
  double eps_slope_spm = 0.0;    ///< d eps/dv [s/m]; |v eps'| well below 1
  double reservoir_m2ps2 = 0.0;  ///< w before, >= 0
};

/// Distribution of the fluctuation r = eps~ - eps(v) of one impact, eps~ = v'/v of the centre:
///
///   r/(1 + eps) = f^2 w/(4 v^2) - q X,   f = 1 + v eps'/(1 + eps),
///   X noncentral chi-square, 2 degrees of freedom, lambda = (f - 2 q)^2 w/(4 q v^2)
///
/// f, for eps acts at the contact's speed; f - 2 q, for contacts that approach faster are more frequent. For w = 0 this
/// is an exponential below 0 of mean distance 2 q (1 + eps); for w >> q v^2 nearly a normal of standard deviation (1 +
/// eps) f sqrt(q w)/v. Assumes normal offsets and one asperity a contact; relative errors of order q and q w/v^2: meant
/// for q < 1e-2 and q w < 0.1 v^2. A value; cheap to make.
class Fluctuation {
 public:
  /// @param q   in (0, 0.1]
  /// @param at  in the ranges stated there; finite
  /// @throws InvalidArgument naming the quantity and its value
  Fluctuation(double q, const ImpactConditions& at);

  /// The fluctuation cannot reach above it: (1 + eps) f^2 w/(4 v^2).
  double highest() const;

  /// ln p(r); -infinity above highest().
  double log_density(double r) const;

  /// Probability of a fluctuation below r (the probability transform). Absolute error 1e-12; on the lower side, down to
  /// probabilities of 1e-14, relative error 1e-8.
  double cdf(double r) const;

  /// The r below which it falls with probability p. @param p  in (0, 1); error of cdf(quantile(p)) 1e-11
  /// @throws InvalidArgument where p is not in (0, 1)
  double quantile(double p) const;

  /// Consumes two normal numbers.
  double draw(Random& random) const;

  /// The reservoir after the impact, in the mean over what r leaves open [m^2/s^2]:
  ///
  ///   w' = w - 2 p v x + p^2 E[t^2|r],   p = (1 + eps + r) v,   f x = (1 + r/(1 + eps)) (1 + E[t^2|r]) - 1
  ///
  /// to leading order w - 2 v^2 r - (1 - eps^2) v^2 E[t^2|r]: what the vertical motion loses beyond eps(v), the
  /// reservoir gains, but for what the contact dissipates of it. t, the offset over R times sqrt(c), enters in the
  /// mean.
  /// @param r  at most highest(); above it (measured with error) offsets are taken as those of highest()
  /// @return >= 0
  double reservoir_after(double r) const;

 private:
  double radius(double r) const;  ///< sqrt(X)
  double mean_square_offset(double r) const;
  double kick(double r) const;  ///< p
  ImpactConditions at_;
  double q_, f_;
  double top_;     ///< f^2 w/(4 v^2)
  double centre_;  ///< sqrt(lambda)
};

/// Mean distances of the two exponentials below and above eps(v).
struct FluctuationSides {
  double below = 0.0, above = 0.0;
  /// ln of the density exp(r/below)/(below + above) for r < 0, exp(-r/above)/(below + above) for r > 0.
  double log_density(double r) const;
};

/// The fluctuation where of the past only the speeds are known: Fluctuation averaged over an exponential reservoir of
/// mean 2 q S. It is exactly two exponentials,
///
///   below * above = ((1 + eps) f q)^2 S/v^2,   below - above = 2 (1 + eps) q (1 - q (f - q) S/v^2)
///
/// @param at             its reservoir is not used
/// @param path_m2ps2     S = sum of (1 + eps)^2 v^2 over the drop's earlier impacts, >= 0 [m^2/s^2]
/// @throws InvalidArgument as Fluctuation
FluctuationSides fluctuation_sides(double q, const ImpactConditions& at, double path_m2ps2);

}  // namespace bouncelab
