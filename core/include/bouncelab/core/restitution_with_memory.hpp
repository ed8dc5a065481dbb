// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

// Alone of all headers here this one needs C++11 and nothing else: copy it into a discrete-element (DEM) code.

namespace bouncelab {

/// A coefficient of restitution that fluctuates as that of a rough ball does, with one number of memory per grain.
///
/// Draws where the ball touches and returns v'/v of its centre, normal to the plate. What a bounce takes out of the
/// normal motion goes into the grain's reservoir, and later bounces give it back: energy is only lost as 1 - eps^2 of
/// the contact demands. Independent random numbers cannot do this, for p(eps~|v) depends on the drop's history.
/// The law of Fluctuation (core/fluctuation.hpp, docs/physics.md section 7), the collision itself not linearised. For
/// codes that do not resolve spin: the reservoir is the grain's spin and sideways motion, as far as bounces made it.
///
/// @param v_mps            normal approach speed, > 0 [m/s]
/// @param eps              callable, eps(v) at the point of contact, in [0, 1], for v > 0 [m/s]
/// @param q                of the grain, > 0: `bouncelab roughness`, or c s2 of docs/physics.md
/// @param z1               standard normal random number, as is z2; new ones at every impact
/// @param reservoir_m2ps2  w of the grain, 0 for one released at rest; updated, stays >= 0 [m^2/s^2]
/// @return eps~; may exceed 1, is > -1
template <class Law>
double restitution_with_memory(double v_mps, const Law& eps, double q, double z1, double z2, double& reservoir_m2ps2) {
  const double s = std::sqrt(q), u = std::sqrt(reservoir_m2ps2);
  // approach of the contact: v + u s z1, weighted by itself, for contacts that approach faster are more frequent
  const double approach = std::sqrt((v_mps + u * s * z1) * (v_mps + u * s * z1) + 2 * q * u * u);
  const double along = (2 * v_mps * s * z1 + q * u * (z1 * z1 + 2)) / (approach + v_mps);  // (approach - v)/u
  const double across = s * z2;
  const double kick = (1 + eps(approach)) * approach / (1 + along * along + across * across);
  reservoir_m2ps2 = (u - along * kick) * (u - along * kick) + across * kick * across * kick;
  return kick / v_mps - 1;
}

}  // namespace bouncelab
