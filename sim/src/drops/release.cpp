// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/experiment.hpp"

namespace bouncelab::sim {
namespace {

/// Uniform on the rotations (Shoemake, Graphics Gems III (1992), 124).
Quaternion random_orientation(Random& random) {
  const double u = random.uniform();
  const double p = 2.0 * std::numbers::pi * random.uniform(), q = 2.0 * std::numbers::pi * random.uniform();
  const double a = std::sqrt(1.0 - u), b = std::sqrt(u);
  return normalized(Quaternion{a * sin(p), a * cos(p), b * sin(q), b * cos(q)});
}

}  // namespace

BallState release(const SimulationConfig& config, std::int64_t drop) {
  Random random(config.seed, RandomStream::drop_start, static_cast<std::uint64_t>(drop));
  BallState state;
  state.clearance_m = random.uniform(config.drop_height_min_m, config.drop_height_max_m);
  state.orientation = random_orientation(random);
  state.x_m = config.start_position_m[0];
  state.y_m = config.start_position_m[1];
  state.motion.velocity_mps = {config.start_velocity_mps[0], config.start_velocity_mps[1], 0.0};
  state.motion.spin_radps = {config.start_spin_radps[0], config.start_spin_radps[1], config.start_spin_radps[2]};
  return state;
}

}  // namespace bouncelab::sim
