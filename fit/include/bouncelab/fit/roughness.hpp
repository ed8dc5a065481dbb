// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/memory_fit.hpp"

namespace bouncelab::fit {

struct RoughnessConfig {
  std::size_t n_goodness = 99;  ///< replicates of the Anderson-Darling test; 0: none
  std::uint64_t seed = 1;       ///< of draws and replicates
  int n_threads = 0;            ///< 0: all cores; the result does not depend on it
};

struct RoughnessResult {
  MemoryFit memory;                               ///< with the roughness, of the ball that the samples name
  std::map<std::string, std::size_t> n_left_out;  ///< by reason
  std::vector<std::string> warnings;
};

/// The roughness of a ball from how its coefficients of restitution scatter: fit_memory with the series A2, A4, A5, and
/// q translated into surfaces. Samples with a flag, not finite or with v <= 0 are left out and counted.
RoughnessResult measure_roughness(const RestitutionSamples& samples, const RoughnessConfig& config);

/// Surfaces of that q where J = inertia_factor m R^2: q = c s2 with c = 1/(1 + inertia_factor) without slip and c =
/// 1/inertia_factor without friction (docs/physics.md, 7); asperities as sim::contact_offset has them.
/// @param inertia_factor  in (0, 1]
/// @throws InvalidArgument where it is not
Roughness equivalent_surfaces(const Estimate& q, double inertia_factor);

/// Share of the reservoir that a bounce loses: 1 - keep.
Estimate leak_of(const MemoryFit& memory);

/// Do the fluctuations remember? A sentence with its tests, and where they do not what to use instead.
std::string in_words(const MemoryFit& memory);
/// "q = 1.40e-06 ± 5e-08 (95 %: 1.3e-06 to 1.5e-06), rms tilt of the contact's normal 0.11 degrees without slip"
std::string in_words(const Roughness& roughness);

}  // namespace bouncelab::fit
