// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "quadrature.hpp"

namespace bouncelab {

/// Force of an elastic Hertz contact over its duration: s in [0, 1] is time over contact time, the integral is 1.
///
///   F(s) ~ x^(3/2),   x'' = -(5/4) x^(3/2)  in the time unit (largest indentation)/v
///
/// The shape is universal: material, radius and speed only scale it (Johnson, Contact Mechanics (1985), 11.4). It
/// starts like s^(3/2), softer than the half-sine often used, which matters for a picker that looks at the first
/// samples.
double hertz_force(double s);

/// The pulse as point impulses: sum_q weight_q delta(s - node_q), total weight 1. Convolved with anything smooth over
/// 1/n of the contact time it is the pulse itself: the rule is Gauss-Legendre in theta, s = (1 - cos theta)/2, where
/// the force is analytic, so it converges geometrically.
QuadratureRule hertz_impulses(int n);

/// The smallest of a few ready rules that is exact within 1e-9 for a contact of this many samples seen through a filter
/// that ends at half the sample rate. @param duration_samples  in (0, kMaxContact_samples]
const QuadratureRule& hertz_impulses_for(double duration_samples);
inline constexpr double kMaxContact_samples = 1600.0;

}  // namespace bouncelab
