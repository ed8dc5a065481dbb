// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/sim/contact.hpp"

namespace bouncelab::sim {

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
