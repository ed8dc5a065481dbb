// SPDX-License-Identifier: GPL-3.0-or-later
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
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/sim/energy.hpp"

namespace bouncelab::loop {

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
/// @param match       OnsetScore::match: for each true time the index of its onset
/// @param samples     of `onsets`
/// @param fitted      of `samples`
/// @return nothing where there is no law, or fewer than 3 drops, or none that scatters
std::optional<ReservoirCheck> reservoir_check(const Impacts& simulated, const std::vector<sim::Reservoir>& reservoirs,
                                              const Onsets& truth, const Onsets& onsets,
                                              const std::vector<std::optional<std::size_t>>& match,
                                              const RestitutionSamples& samples, const fit::FitResult& fitted,
                                              double gravity_mps2);

}  // namespace bouncelab::loop
