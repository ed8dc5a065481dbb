// SPDX-License-Identifier: GPL-3.0-or-later
/// The simulation beside theory: its scatter in closed form, its reservoir from sound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/sim/contact.hpp"
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
  /// Of the simulated impacts, by twentieths of the transform.
  std::vector<std::size_t> transform_counts = std::vector<std::size_t>(20);
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

/// What the reservoir of one drop gained over the longest chain of impacts that sound and simulation both know.
struct ReservoirOfDrop {
  std::int64_t drop = 0;
  std::int64_t first_impact = 0, last_impact = 0;  ///< of the chain
  double simulated_m2ps2 = 0.0;                    ///< after the last impact less before the first
  fit::ReservoirGain sound;
};
Description members_of(const ReservoirOfDrop*);

/// The paper's explanation of its scatter, measured: the energy that impacts move out of the vertical motion, as the
/// times of the sound give it, beside the energy of sideways motion and spin as simulated.
struct ReservoirCheck {
  bool with_memory = false;            ///< the law is that of the fit with memory, else of independent impacts
  std::vector<ReservoirOfDrop> drops;  ///< those with two impacts or more in a chain
  double correlation = 0.0;            ///< over the drops, of simulated and sound
  double rms_simulated_m2ps2 = 0.0;
  double mean_difference_m2ps2 = 0.0;  ///< sound less simulated
  double rms_difference_m2ps2 = 0.0;
  /// Root mean square over the drops of the errors expected. That of the law is common to all drops.
  double expected_timing_m2ps2 = 0.0, expected_offset_m2ps2 = 0.0;
  std::optional<double> expected_law_m2ps2;
  /// Share of spin in the simulated reservoir after the chains' last impacts, of the sums over all drops: 2/7 without
  /// slip, 1 without friction.
  double spin_share = 0.0;
};
Description members_of(const ReservoirCheck*);

/// @param simulated   whole drops; states are not used
/// @param reservoirs  sim::reservoirs_after() of them
/// @param truth       the true times as onsets; `drop` and `impact` number the impact simulated
/// @param match       DetectorScore::match: for each true time the index of its onset
/// @param samples     of `onsets`
/// @param fitted      of `samples`
/// @return nothing where there is no law, or fewer than 3 drops, or none that scatters
std::optional<ReservoirCheck> reservoir_check(const Impacts& simulated, const std::vector<sim::Reservoir>& reservoirs,
                                              const Onsets& truth, const Onsets& onsets,
                                              const std::vector<std::optional<std::size_t>>& match,
                                              const RestitutionSamples& samples, const fit::FitResult& fitted,
                                              double gravity_mps2);

}  // namespace bouncelab::loop
