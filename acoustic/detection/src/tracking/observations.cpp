// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/observations.hpp"

#include <algorithm>

#include "bouncelab/core/elementary.hpp"
#include "tracking/rise_odds.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kSharp_s = 1.8e-3;       // reach of the shortest window at 4 kHz and more; at 1 kHz all are longer
constexpr double kTimingOfReach = 0.15;   // what a longer window has noticed is timed by a part of it
constexpr double kSamplesOfTiming = 2.0;  // error of the times in samples
constexpr double kShortestWindow_s = 0.4e-3;

}  // namespace

Observations::Observations(const std::vector<Candidate>& candidates, double timing_s, const SameSource& same_source,
                           const TrackingModel& model)
    : candidates_(candidates), same_source_(same_source), model_(model) {
  const std::vector<double> rise = log_rise_odds(candidates, kShortestWindow_s * kSamplesOfTiming / timing_s, model);
  log_amplitudes_.reserve(candidates.size());
  for (const Candidate& c : candidates) log_amplitudes_.push_back(log(c.amplitude));
  const std::vector<Neighbours> neighbours = count_neighbours(candidates, log_amplitudes_, same_source_, model);
  observations_.reserve(candidates.size());
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const Candidate& c = candidates[k];
    const double sigma_s = c.reach_s < kSharp_s ? timing_s : std::max(timing_s, kTimingOfReach * c.reach_s);
    observations_.push_back({c.t_s, sigma_s, log_amplitudes_[k], rise[k], neighbours[k]});
  }
}

Observation Observations::without(std::size_t k, const std::vector<std::size_t>& explained) const {
  Observation observation = observations_[k];
  observation.neighbours = count_neighbours_of(k, candidates_, log_amplitudes_, same_source_, explained, model_);
  return observation;
}

double Observations::same_source(std::size_t j, std::size_t k) const { return same_source_.weight(j, k); }

void Observations::same_source(std::size_t k, std::size_t first, std::span<float> weights) const {
  same_source_.weigh(k, first, weights);
}

std::optional<double> Observations::same_source_probability_of(std::size_t j, std::size_t k) const {
  return same_source_.probability(j, k);
}

}  // namespace bouncelab::detection
