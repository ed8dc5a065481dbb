// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/theory.hpp"

namespace bouncelab::loop {

/// Slopes of p(eps) that docs/physics.md, section 7, expects in a window of speeds.
struct ExpectedSlopes {
  double v_mps = 0.0;                  ///< centre of the window
  std::size_t n = 0;                   ///< simulated impacts in it
  double rising = 0.0, falling = 0.0;  ///< per unit eps, both positive; rising below eps(v)
};
Description members_of(const ExpectedSlopes*);

/// p(eps) that docs/physics.md, section 7, expects in a window of speeds, and the simulated impacts in the bins of its
/// histogram.
struct ExpectedDensity {
  double v_mps = 0.0;                         ///< centre of the window
  std::vector<double> eps, density;           ///< without timing noise
  std::size_t n_simulated = 0;                ///< impacts in the window, in a bin or not
  std::vector<std::size_t> simulated_counts;  ///< in the bins of the histogram
};
Description members_of(const ExpectedDensity*);

/// The closed form of the scatter beside the simulation that it is to agree with. No parameter is fitted.
struct ScatterTheory {
  double q = 0.0;                ///< contact_factor * offset_variance
  double contact_factor = 0.0;   ///< c
  double offset_variance = 0.0;  ///< s2
  std::vector<ExpectedSlopes> slopes;
  std::vector<ExpectedDensity> densities;
  std::size_t n_transforms = 0;
  std::array<std::size_t, 20> transform_counts{};  ///< of the simulated impacts, by twentieths of the transform
};
Description members_of(const ScatterTheory*);

/// Slopes: one over the mean, over the simulated impacts of the window, of the mean distances that fluctuation_sides()
/// has at the window's centre and the impact's own past S. Densities: the mean of those two exponentials over the same
/// impacts; impacts are moved to the centre as the fit moves samples, their fluctuation by the ratio of its mean
/// distance there to that at their own speed. Transforms: of sim::probability_transforms(). Of a drop with an impact
/// that meets the ball on its way up, the impacts before it.
/// @param surface  where the simulated ball touches (sim::contact_offset)
/// @param impacts  whole drops, from the first impact on; states are not used
/// @param windows  of whose speeds slopes are asked for, and densities where they have bins; those without impacts are
///                 left out
/// @return nothing where the closed form does not apply: the ball released with spin or sideways motion, the plate
///         tilted, offsets averaged over a patch, a smooth ball, q above 0.1
std::optional<ScatterTheory> scatter_theory(const sim::SimulationConfig& config, const sim::ContactOffset& surface,
                                            const Impacts& impacts, const std::vector<fit::HistogramFit>& windows);

/// Offsets of the ball of an experiment.
/// @param given  the surface simulated; null: n_asperities drawn from the law
sim::ContactOffset contact_offset_of(const Ball& ball, const sim::Surface* given, const sim::RadiusLaw& law,
                                     std::int64_t n_asperities, int n_threads = 0);

}  // namespace bouncelab::loop
