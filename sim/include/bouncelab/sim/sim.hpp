// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: a rough ball bouncing on a plate. make_surface, then simulate; the rest is what these are made of.
#pragma once

#include "bouncelab/sim/contact.hpp"     // the collision: paper, frictionless, Coulomb, Stronge; where the energy goes
#include "bouncelab/sim/envelope.hpp"    // what can touch the plate, and where
#include "bouncelab/sim/experiment.hpp"  // many drops: SimulationConfig -> Impacts
#include "bouncelab/sim/flight.hpp"      // the first contact of a flight, drag, patches of contact
#include "bouncelab/sim/surface.hpp"     // asperities, drawn or read; the ball cut through its centre
#include "bouncelab/sim/theory.hpp"      // the scatter in closed form
#include "bouncelab/sim/vector3.hpp"     // vectors and rotations
