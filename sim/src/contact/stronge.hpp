// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/sim/vector3.hpp"
#include "contact/mobility.hpp"

namespace bouncelab::sim {

/// Impulse of a rigid collision with Coulomb friction and energetic restitution, followed in the normal impulse p:
///
///   dv/dp = K (f, 1),   slip: f = -mu s/|s|,   stick: f keeps s = 0 (while |f| <= mu),   s: v without its normal part
///
/// until restitution has done eps^2 of the normal work of compression,
///
///   int_{v_z > 0} v_z dp = -eps^2 int_{v_z < 0} v_z dp
///
/// The slip turns while it lasts. f is constant within a step and opposes the step's mean slip (implicit midpoint
/// rule), so that each step's work is known exactly: friction's is never positive, at any length of step, and the
/// normal work is what restitution asks for, to rounding. Steps are so short that the slip turns by 0.02 rad; a slip of
/// constant direction takes one step to its end. Error of the impulse: 3e-4 of mu P_n in 99 of 100 approaches, at most
/// 2e-3.
/// @param v    velocity of the contact point before, v.z < 0 [m/s]
/// @param mu   >= 0
/// @param eps  energetic coefficient of restitution, >= 0
/// Source: Stronge, Proc. R. Soc. A 431, 169 (1990), doi:10.1098/rspa.1990.0125; Impact Mechanics (2nd ed., 2018).
Vector3 stronge_impulse(const Mobility& k, Vector3 v, double mu, double eps);

}  // namespace bouncelab::sim
