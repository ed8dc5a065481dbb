// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "candidates/candidates.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// log of p(LLR | event) / p(LLR | any candidate around), for each candidate: what its rise says about whether it is an
/// event at all.
///
/// Where a sound rings, its variance fluctuates, and candidates stand wherever that passes the threshold: there z = LLR
/// - threshold is distributed exponentially, with a mean of 1 in white noise and of some units in a ringing sound. What
/// an event adds has no scale: z has the density z0 / (z0 + z)^2. The share of events among the nearest candidates in
/// time is estimated by expectation and maximisation, with a prior of one half.
/// @param n_in_window  samples in the shortest window of a candidate; LLR is in proportion to it
std::vector<double> log_rise_odds(const std::vector<Candidate>& candidates, double n_in_window,
                                  const TrackingModel& model);

}  // namespace bouncelab::detection
