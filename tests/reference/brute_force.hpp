// SPDX-License-Identifier: GPL-3.0-or-later
/// The simulator's brute-force twin: every asperity is looked at in every flight, by bisection; the collision solves
/// its 3x3 system by elimination. Slow, simple, and sharing nothing with the simulator but its value types.
#pragma once

#include <cstdint>
#include <optional>

#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/flight.hpp"

namespace bouncelab::sim::reference {

/// The first closing of any gap after the start; `left` as in find_first_contact.
FirstContact first_contact(const Ball& ball, const Surface& surface, const BallState& start, double gravity_mps2,
                           std::optional<std::int64_t> left);

/// The paper's rule, eqs. 6-10.
Motion collide_paper(const Ball& ball, const RestitutionLaw& law, double beta, Vector3 lever_m, const Motion& before);

/// The state in which a simulated impact left the ball.
BallState state_after(const Ball& ball, const ImpactState& impact);

}  // namespace bouncelab::sim::reference
