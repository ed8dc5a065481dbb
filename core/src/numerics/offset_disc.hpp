// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab {

// A standard normal point of the plane, with its mean at distance `a` from the middle of a disc of radius `b`. The
// square of its distance from the middle is a noncentral chi-square with 2 degrees of freedom and lambda = a^2.
// All for a, b >= 0, whatever their size.

/// exp(-z) I0(z). @param z  >= 0; relative error 1e-14
double scaled_bessel_i0(double z);
/// I1(z)/I0(z), in [0, 1). @param z  >= 0; error 1e-14
double bessel_ratio(double z);
/// Variance of cos(phi) where phi has the density exp(-z cos phi)/(2 pi I0(z)). @param z  >= 0; relative error 1e-7
double cosine_variance(double z);

/// Probability that the point lies outside the disc (Marcum's Q function). Absolute error 1e-12; where b > a and the
/// probability is above 1e-14, relative error 1e-8.
double probability_outside_disc(double a, double b);
/// The radius for which it lies outside with probability p in (0, 1).
double disc_radius(double a, double p);

}  // namespace bouncelab
