// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "candidates.hpp"

namespace bouncelab {

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
/// scores log[ p_heard p(log eps) |d log eps / dt| / lambda ], eps = (t - t_last)/T, where p is a Student core about
/// the running mean of the train (so that eps(v) may drift, whatever the material) plus a flat part for single losses
/// and gains, and lambda the rate, in the neighbourhood, of candidates at least as strong: what chance would offer. Up
/// to two successive impacts may be missing. A train has at least five impacts and loses energy on the whole.
/// @param timing_s  error of the candidates' times, standard deviation [s]
std::vector<Train> find_trains(const std::vector<Candidate>& candidates, double timing_s);

}  // namespace bouncelab
