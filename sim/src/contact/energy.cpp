// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/energy.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::sim {
namespace {

Motion motion_of(const std::array<double, 3>& velocity_mps, const std::array<double, 3>& spin_radps) {
  return {{velocity_mps[0], velocity_mps[1], velocity_mps[2]}, {spin_radps[0], spin_radps[1], spin_radps[2]}};
}

}  // namespace

KineticEnergy kinetic_energy(const Ball& ball, const Motion& motion) {
  const double m = mass_kg(ball);
  const Vector3 v = motion.velocity_mps;
  return {0.5 * m * v.z * v.z, 0.5 * m * (v.x * v.x + v.y * v.y),
          0.5 * moment_of_inertia_kgm2(ball) * norm2(motion.spin_radps)};
}

ImpactEnergy impact_energy(const Ball& ball, const Motion& before, const Motion& after) {
  ImpactEnergy energy{kinetic_energy(ball, before), kinetic_energy(ball, after)};
  const double gained = energy.after.total_j() - energy.before.total_j();
  energy.dissipated_j = std::max(0.0, -gained);
  energy.created_j = std::max(0.0, gained);
  return energy;
}

ImpactEnergy impact_energy(const Ball& ball, const ImpactState& s) {
  return impact_energy(ball, motion_of(s.velocity_mps, s.spin_radps),
                       motion_of(s.velocity_after_mps, s.spin_after_radps));
}

Reservoir reservoir(const Ball& ball, const Motion& motion) {
  const Vector3 v = motion.velocity_mps, spin = motion.spin_radps;
  return {square(v.x) + square(v.y), moment_of_inertia_kgm2(ball) / mass_kg(ball) * (square(spin.x) + square(spin.y))};
}

std::vector<Reservoir> reservoirs_after(const Ball& ball, const Impacts& impacts) {
  if (impacts.states.size() != impacts.rows.size())
    throw InvalidArgument("reservoirs need the state of every impact; simulate with states");
  std::vector<Reservoir> reservoirs;
  reservoirs.reserve(impacts.states.size());
  for (const ImpactState& s : impacts.states)
    reservoirs.push_back(reservoir(ball, motion_of(s.velocity_after_mps, s.spin_after_radps)));
  return reservoirs;
}

double EnergyLedger::closure() const {
  return (released_j + created_j - dissipated_j - drag_j - remaining_j) / released_j;
}

void EnergyLedger::add(const ImpactEnergy& impact) {
  dissipated_j += impact.dissipated_j;
  created_j += impact.created_j;
  // a lossless impact gains a few ulp by rounding: that is not creation
  n_creating += impact.created_j > 1e-14 * impact.before.total_j() ? 1 : 0;
  gained_impact_j.vertical_j += impact.after.vertical_j - impact.before.vertical_j;
  gained_impact_j.horizontal_j += impact.after.horizontal_j - impact.before.horizontal_j;
  gained_impact_j.rotational_j += impact.after.rotational_j - impact.before.rotational_j;
}

void EnergyLedger::add(const EnergyLedger& other) {
  released_j += other.released_j;
  remaining_j += other.remaining_j;
  dissipated_j += other.dissipated_j;
  created_j += other.created_j;
  drag_j += other.drag_j;
  n_creating += other.n_creating;
  gained_impact_j.vertical_j += other.gained_impact_j.vertical_j;
  gained_impact_j.horizontal_j += other.gained_impact_j.horizontal_j;
  gained_impact_j.rotational_j += other.gained_impact_j.rotational_j;
}

namespace {

/// The q-quantile by nearest rank: always one of the values.
double nearest_quantile(const std::vector<double>& values, double q) {
  return order_statistic(values, static_cast<std::size_t>(std::llround(q * static_cast<double>(values.size() - 1))));
}

}  // namespace

std::vector<EnergyShares> energy_shares(const Ball& ball, const Impacts& impacts) {
  if (impacts.states.size() != impacts.rows.size())
    throw InvalidArgument("energy shares need the state of every impact; simulate with states");
  std::vector<EnergyShares> shares;
  std::vector<std::vector<double>> rotational;
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    const auto number = static_cast<std::size_t>(impacts.rows[k].impact);
    while (shares.size() <= number) shares.push_back({static_cast<std::int64_t>(shares.size())});
    rotational.resize(shares.size());
    const KineticEnergy energy = impact_energy(ball, impacts.states[k]).before;
    EnergyShares& sum = shares[number];
    ++sum.n;
    sum.vertical += energy.vertical_j / energy.total_j();
    sum.horizontal += energy.horizontal_j / energy.total_j();
    rotational[number].push_back(energy.rotational_j / energy.total_j());
    sum.rotational += rotational[number].back();
  }
  for (std::size_t k = 0; k < shares.size(); ++k) {
    EnergyShares& mean = shares[k];
    if (mean.n == 0) continue;
    for (double* share : {&mean.vertical, &mean.horizontal, &mean.rotational}) *share /= static_cast<double>(mean.n);
    mean.rotational_lo = nearest_quantile(rotational[k], 0.16);
    mean.rotational_hi = nearest_quantile(rotational[k], 0.84);
  }
  return shares;
}

}  // namespace bouncelab::sim
