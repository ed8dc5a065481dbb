// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/impacts.hpp"

namespace bouncelab::sim {

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

/// @param impacts  with states
/// @return ordered by number of the impact, none missing in between
/// @throws InvalidArgument where the states are not there
std::vector<EnergyShares> energy_shares(const Ball& ball, const Impacts& impacts);

}  // namespace bouncelab::sim
