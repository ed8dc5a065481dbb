// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/contact.hpp"

#include <gtest/gtest.h>

#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/experiment.hpp"

namespace bouncelab::sim {
namespace {

SimulationConfig config_with_states() {
  SimulationConfig config;
  config.n_drops = 40;
  config.n_impacts_max = 80;
  config.with_state = true;
  config.n_threads = 1;
  return config;
}

TEST(EnergyShares, OfARoughBallMoveFromVerticalToRotationAndHorizontalMotionBounceByBounce) {
  const SimulationConfig config = config_with_states();
  const Surface surface = make_surface(config.ball, 20'000, UniformRadii{}, 1);
  const std::vector<EnergyShares> shares = energy_shares(config.ball, simulate(config, surface).impacts);
  ASSERT_EQ(shares.size(), 80u);
  for (const EnergyShares& s : shares) {
    EXPECT_EQ(s.n, 40u);
    EXPECT_NEAR(s.vertical + s.horizontal + s.rotational, 1.0, 1e-14);  // 40 sums of three quotients, rounded
    EXPECT_LE(s.rotational_lo, s.rotational_hi);
  }
  EXPECT_EQ(shares[0].vertical, 1.0);  // released at rest
  // asperities do not pull back what they set going: over decades of bounces the share grows
  EXPECT_GT(shares[10].rotational, shares[1].rotational);
  EXPECT_GT(shares[79].rotational, shares[10].rotational);
  EXPECT_LT(shares[79].vertical, 1.0);
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
  EXPECT_THROW(energy_shares(config.ball, result.impacts), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::sim
