// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"

namespace bouncelab::detection {

/// One impact of a train.
struct TrainImpact {
  std::size_t candidate = 0;  ///< index into the candidates
  std::int64_t impact = 0;    ///< number within the train; jumps where an impact was not heard
};

/// One drop: a chain of candidates whose intervals shrink as those of a bouncing ball.
struct Train {
  std::vector<TrainImpact> impacts;
  double log_odds = 0.0;  ///< against chance
};

/// The set of trains, one after the other in time, that is most probable against chance.
///
/// Dynamic programming over (last impact, last flight time T, running mean of log eps). An impact at t after a flight T
/// scores log[ p_heard p(log eps) |d log eps / dt| / c ], eps = (t - t_last)/T, where p is a Student core about the
/// running mean of the train (so that eps(v) may drift, whatever the material) plus a flat part for single losses and
/// gains, and c what chance or a rhythm would offer (clutter.hpp); and the odds that its loudness goes with its speed.
/// Chance is offered less where the sound is of the train's kind and few others around are.
/// Once the ball is known, impacts before a train's first are looked for.
/// A train may miss up to two successive impacts. A train has at least four impacts, loses energy on the whole, and
/// more than it scatters (bounce_model.hpp).
/// @param timing_s  error of the candidates' times, standard deviation [s]; where only a longer window noticed, 0.15 of
/// it
/// @param band_energies   of the candidates, or none: then they are not judged by them
std::vector<Train> find_trains(const std::vector<Candidate>& candidates, double timing_s,
                               const std::vector<BandEnergies>& band_energies = {});

}  // namespace bouncelab::detection
