// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "memory/chains.hpp"
#include "memory/memory_parameters.hpp"

namespace bouncelab::fit {

/// A chain as the model would have it: the first speed and all errors as in `like`; the first reservoir, impacts
/// (restitution_with_memory), heights of contacts and timing errors drawn. Heights are exponential and independent.
/// @param height_sd_m  their standard deviation, Chains::height_sd_m
Chain draw_chain(const Chain& like, const RestitutionLaw& law, const MemoryParameters<double>& parameters,
                 double height_sd_m, Random& random);

}  // namespace bouncelab::fit
