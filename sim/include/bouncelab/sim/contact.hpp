// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <variant>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

/// The paper's eqs. 6-10 literally: v_c'.t = beta v_c.t with the fully coupled impulse. beta = 1 is not frictionless:
/// an eccentric impulse would change v_c.t, so the impulse has a tangential part, which can create energy.
struct PaperContact {
  double beta = 1.0;  ///< in [-1, 1]
};
/// The impulse is parallel to the plate's normal.
struct FrictionlessContact {};
/// Stick (v_c'.t = 0) where the impulse this needs lies in the cone |P_t| <= mu P_n; else the tangential impulse is the
/// sticking one shortened to mu P_n, with P_n such that v_c'.n = -eps v_c.n still holds. Newton's restitution: where
/// the contact is eccentric it can create energy (docs/physics.md).
struct CoulombContact {
  double mu = 0.2;  ///< >= 0
};
/// Coulomb friction at every instant of the contact, and energetic restitution: the normal force returns eps^2 of the
/// work that it took, int_{v_c.n > 0} v_c.n dP_n = -eps^2 int_{v_c.n < 0} v_c.n dP_n. Creates no energy for eps <= 1.
/// v_c'.n = -eps v_c.n holds where friction does not change on the way, not in general.
/// Source: Stronge, Proc. R. Soc. A 431, 169 (1990), doi:10.1098/rspa.1990.0125.
struct StrongeContact {
  double mu = 0.2;  ///< >= 0
};
using ContactModel = std::variant<PaperContact, FrictionlessContact, CoulombContact, StrongeContact>;

/// @throws InvalidArgument where a parameter is out of its range
void validate(const ContactModel& model);
/// One line for people, e.g. "paper, beta = 1".
std::string describe(const ContactModel& model);

/// Velocities of a rigid ball: of the centre and angular (lab frame).
struct Motion {
  Vector3 velocity_mps;
  Vector3 spin_radps;
};

/// What a collision did.
struct Collision {
  Motion after;
  double v_contact_mps = 0.0;  ///< -v_c.n >= 0
  double eps_contact = 1.0;    ///< eps(v_contact)
  Vector3 impulse_ns;          ///< P, on the ball
};

/// Instantaneous collision of the ball with the fixed plane of normal e_z:
///
///   v_c = v_G + omega x r_c,   v_G' = v_G + P/m,   omega' = omega + (r_c x P)/J,   v_c'.n = -eps(|v_c.n|) v_c.n
///   [ I/m + (|r_c|^2 I - r_c r_c^T)/J ] P = v_c' - v_c
///
/// (StrongeContact: eps(|v_c.n|) is the energetic coefficient in place of the last.) The 3x3 system is inverted in
/// closed form (Sherman-Morrison): a^-1 (I + (m/J) r_c r_c^T), a = 1/m + |r_c|^2/J.
/// @param lever_m  r_c, from the centre to the point of contact [m]
/// @param before   approaching: v_c.n < 0
/// Nothing is clamped: v_G'.n may exceed |v_G.n| or be negative. Source: Montaine et al. (2011), eqs. 6-10,
/// doi:10.1103/PhysRevE.84.041306.
Collision collide(const Ball& ball, const RestitutionLaw& law, const ContactModel& model, Vector3 lever_m,
                  const Motion& before);

}  // namespace bouncelab::sim
