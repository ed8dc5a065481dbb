// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/energy.hpp"
#include "bouncelab/sim/experiment.hpp"

namespace bouncelab::sim {
namespace {

/// Energies of sideways motion and spin before the last impact of each drop, as simulated and as the residuals
/// eps~ - eps(v) of the earlier impacts add them up: U' = U - 2 c v^2 r - 2 c^2 (1 - eps^2) v^2 s2, E = m U / (2 c).
struct Energies {
  std::vector<double> simulated_j, from_residuals_j, rotational_share;
};
Energies energies(const ContactModel& contact, double c) {
  SimulationConfig config;
  config.contact = contact;
  config.n_drops = 40;
  config.n_impacts_max = 60;
  config.n_threads = 1;
  config.with_state = true;
  constexpr std::int64_t kAsperities = 200'000;
  const double s2 = 2.0 / kAsperities, m = mass_kg(config.ball);
  const SimulationResult result = simulate(config, make_surface(config.ball, kAsperities, ConstantRadii{1e-3}, 4));
  Energies all;
  double u2 = 0.0;
  for (std::size_t k = 0; k < result.impacts.rows.size(); ++k) {
    const Impact& impact = result.impacts.rows[k];
    if (impact.impact == 0) u2 = 0.0;
    if (impact.impact == config.n_impacts_max - 1) {
      const KineticEnergy before = impact_energy(config.ball, result.impacts.states[k]).before;
      all.simulated_j.push_back(before.horizontal_j + before.rotational_j);
      all.from_residuals_j.push_back(m * u2 / (2.0 * c));
      all.rotational_share.push_back(before.rotational_j / all.simulated_j.back());
    }
    const double v2 = impact.v_mps * impact.v_mps, eps = restitution(config.law, impact.v_mps);
    u2 -= 2.0 * c * v2 * (impact.eps_macro - eps) + 2.0 * c * c * (1.0 - eps * eps) * v2 * s2;
  }
  return all;
}

void expect_same_energy(const Energies& reservoir) {
  double difference2 = 0.0, energy2 = 0.0;
  for (std::size_t k = 0; k < reservoir.simulated_j.size(); ++k) {
    const double d = reservoir.from_residuals_j[k] - reservoir.simulated_j[k];
    difference2 += d * d;
    energy2 += reservoir.simulated_j[k] * reservoir.simulated_j[k];
  }
  // to first order in the offsets; left out are eps(v) at the contact in place of the centre's and theta^2 in place of
  // its mean, (1 - eps) of each impact's exchange and some 0.3 to 1 % of the energy
  EXPECT_LT(std::sqrt(difference2 / energy2), 0.02);
}

TEST(Reservoir, WhatTheVerticalMotionLostIsSidewaysMotionAndSpin) {
  const Energies paper = energies(PaperContact{}, 5.0 / 7.0);
  expect_same_energy(paper);
  // without slip spin and sideways motion go together as in rolling: rotation holds 2/7
  for (const double share : paper.rotational_share) EXPECT_NEAR(share, 2.0 / 7.0, 0.02);  // of order the offsets, 1e-2
}

TEST(Reservoir, IsSpinAloneWithoutFriction) {
  const Energies frictionless = energies(FrictionlessContact{}, 5.0 / 2.0);
  expect_same_energy(frictionless);
  for (const double share : frictionless.rotational_share) EXPECT_EQ(share, 1.0);
}

TEST(Reservoir, AfterEachImpactIsThatOfItsState) {
  SimulationConfig config;
  config.n_drops = 1;
  config.n_impacts_max = 3;
  config.with_state = true;
  SimulationResult result = simulate(config, make_surface(config.ball, 20'000, ConstantRadii{1e-3}, 4));
  const auto after = reservoirs_after(config.ball, result.impacts);
  ASSERT_EQ(after.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const KineticEnergy energy = impact_energy(config.ball, result.impacts.states[k]).after;
    const double m = mass_kg(config.ball);
    EXPECT_NEAR(after[k].sideways_m2ps2, 2.0 * energy.horizontal_j / m, 1e-15);  // rounding
    EXPECT_LE(after[k].spin_m2ps2, 2.0 * energy.rotational_j / m + 1e-15);       // less the spin about the normal
    EXPECT_GT(after[k].spin_m2ps2, 0.9 * 2.0 * energy.rotational_j / m);  // which is of second order in offsets of .01
  }
  result.impacts.states.clear();
  EXPECT_THROW(reservoirs_after(config.ball, result.impacts), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::sim
