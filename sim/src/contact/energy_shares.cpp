// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/energy_shares.hpp"

#include <cmath>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/statistics.hpp"
#include "bouncelab/sim/energy.hpp"

namespace bouncelab::sim {
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
