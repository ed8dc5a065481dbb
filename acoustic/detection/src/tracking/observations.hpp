// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"
#include "tracking/neighbours.hpp"
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
std::vector<double> log_rise_odds(const std::vector<Candidate>& candidates, double n_in_window);

/// A candidate as the model of tracks sees it.
struct Observation {
  double t_s = 0.0;
  double sigma_s = 0.0;  ///< error of the time
  double log_amplitude = 0.0;
  double log_rise_odds = 0.0;      ///< that it is an event at all (log_rise_odds())
  double log_odds_of_first = 0.0;  ///< of a track that begins with it, before its second impact
  Neighbours neighbours;
  /// The flight after the first impact of a drop, were that elastic: of a height that is known.
  std::optional<double> elastic_flight_s{};
};

/// Those of a recording. Refers to what it is made from.
class Observations {
 public:
  /// @param timing_s       error of the times that the shortest window gives [s]
  /// @param same_source    which of the candidates may have one source
  /// @param duration_s     of the recording, from 0 on
  Observations(const std::vector<Candidate>& candidates, double timing_s, const SameSource& same_source,
               double duration_s = HUGE_VAL, std::optional<double> elastic_flight_s = {});

  std::size_t size() const { return observations_.size(); }
  const Observation& operator[](std::size_t k) const { return observations_[k]; }
  /// The same with what a track explains not counted among its neighbours.
  /// @param explained  indices, rising
  Observation without(std::size_t k, const std::vector<std::size_t>& explained) const;
  /// Weight of one as clutter for the other, or as an impact of the same ball: 1 where they cannot be told apart.
  double same_source(std::size_t j, std::size_t k) const { return same_source_.weight(j, k); }
  double same_source_probability(std::size_t j, std::size_t k) const { return same_source_.probability(j, k); }
  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  const std::vector<Candidate>& candidates_;
  const SameSource& same_source_;
  double duration_s_;
  std::vector<double> log_amplitudes_;
  std::vector<Observation> observations_;
};

}  // namespace bouncelab::detection
