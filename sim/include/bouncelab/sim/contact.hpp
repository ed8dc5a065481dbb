// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/impacts.hpp"
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

/// Kinetic energy by kind.
struct KineticEnergy {
  double vertical_j = 0.0;    ///< m v_z^2 / 2 (normal to the plate)
  double horizontal_j = 0.0;  ///< m (v_x^2 + v_y^2) / 2
  double rotational_j = 0.0;  ///< J omega^2 / 2
  double total_j() const { return vertical_j + horizontal_j + rotational_j; }
};

KineticEnergy kinetic_energy(const Ball& ball, const Motion& motion);

/// Twice the kinetic energy per mass that impacts have moved out of the vertical motion: w of docs/physics.md,
/// section 7. A ball that rolls without slip holds 2/7 of it in spin, one without friction all of it.
struct Reservoir {
  double sideways_m2ps2 = 0.0;  ///< v_x^2 + v_y^2
  double spin_m2ps2 = 0.0;      ///< J (omega_x^2 + omega_y^2) / m; spin about the plate's normal takes no part
  double total_m2ps2() const { return sideways_m2ps2 + spin_m2ps2; }
};
Reservoir reservoir(const Ball& ball, const Motion& motion);
/// After each impact, in their order. @throws InvalidArgument where the states are not there
std::vector<Reservoir> reservoirs_after(const Ball& ball, const Impacts& impacts);

/// What one impact did to the energy: before + created = after + dissipated, to rounding.
struct ImpactEnergy {
  KineticEnergy before, after;
  double dissipated_j = 0.0;  ///< >= 0
  double created_j = 0.0;     ///< >= 0; the `paper` contact with spin can create energy
};
ImpactEnergy impact_energy(const Ball& ball, const Motion& before, const Motion& after);
ImpactEnergy impact_energy(const Ball& ball, const ImpactState& state);

/// The account of a drop or a run; sums over drops and impacts. It closes:
///
///   released + created = dissipated + drag + remaining
///
/// where energies of position count from the plate's centre and `remaining` is after the last impact of each drop.
struct EnergyLedger {
  double released_j = 0.0;   ///< kinetic and potential, at release
  double remaining_j = 0.0;  ///< kinetic and potential, after the last impact
  double dissipated_j = 0.0;
  double created_j = 0.0;
  double drag_j = 0.0;            ///< lost to the air
  long long n_creating = 0;       ///< impacts that created energy
  KineticEnergy gained_impact_j;  ///< sum over impacts of after - before, by kind

  /// released + created - dissipated - drag - remaining, relative to released.
  double closure() const;
  void add(const ImpactEnergy& impact);
  void add(const EnergyLedger& other);
};

/// How the kinetic energy is shared just before the impacts of one number, over all drops: means of the shares, which
/// add up to 1. What the paper explains its scatter by: asperities turn vertical motion into rotation, and back.
struct EnergyShares {
  std::int64_t impact = 0;                          ///< number of the impact within its drop, from 0
  std::size_t n = 0;                                ///< drops that had it
  double vertical = 0.0;                            ///< m v_z^2 / 2 over the kinetic energy
  double horizontal = 0.0;                          ///< m (v_x^2 + v_y^2) / 2
  double rotational = 0.0;                          ///< J omega^2 / 2
  double rotational_lo = 0.0, rotational_hi = 0.0;  ///< 16 % and 84 % quantiles over the drops
};
Description members_of(const EnergyShares*);

/// @param impacts  with states
/// @return ordered by number of the impact, none missing in between
/// @throws InvalidArgument where the states are not there
std::vector<EnergyShares> energy_shares(const Ball& ball, const Impacts& impacts);

}  // namespace bouncelab::sim
