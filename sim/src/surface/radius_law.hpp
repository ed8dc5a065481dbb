// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

/// @throws InvalidArgument where a parameter is out of its range
void validate(const RadiusLaw& law);

/// One radius relative to R, > 0.
double draw_radius(const RadiusLaw& law, Random& random);

}  // namespace bouncelab::sim
