// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "memory/chains.hpp"
#include "memory/filter.hpp"

namespace bouncelab::fit {

/// A chain as the model would have it: the first speed and all errors as in `like`, contacts, heights and timing errors
/// drawn.
Chain draw_chain(const Chain& like, const RestitutionLaw& law, const MemoryParameters<double>& parameters,
                 double ball_radius_m, Random& random);

}  // namespace bouncelab::fit
