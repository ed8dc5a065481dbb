// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/observations.hpp"

#include <algorithm>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"
#include "candidates/candidate_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kRounds = 3;

struct Densities {
  double event = 0.0;
  double fluctuation = 0.0;
  double mixture(double share) const { return share * event + (1.0 - share) * fluctuation; }
};

/// Share of events among the candidates first ... last but k.
double share_of_events(const std::vector<Densities>& densities, std::size_t first, std::size_t last, std::size_t k) {
  double share = 0.5;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.5 * kTracking.events_weight;
    for (std::size_t j = first; j <= last; ++j)
      if (j != k) sum += share * densities[j].event / densities[j].mixture(share);
    share = sum / (kTracking.events_weight + static_cast<double>(last - first));
  }
  return share;
}

constexpr double kShortestWindow_s = 0.4e-3;

}  // namespace

std::vector<double> log_rise_odds(const std::vector<Candidate>& c, double n_in_window) {
  const double z0 = kTracking.event_per_sample * n_in_window;
  const double excess = kTracking.excess + kTracking.excess_per_sample * n_in_window;
  std::vector<Densities> densities;
  for (const Candidate& candidate : c) {
    const double z = std::max(0.0, candidate.log_likelihood_ratio - kCandidates.threshold);
    densities.push_back({z0 / square(z0 + z), exp(-z / excess) / excess});
  }
  std::vector<double> odds(c.size());
  for (std::size_t k = 0; k < c.size(); ++k) {
    std::size_t first = k, last = k;
    while (first > 0 && k - first < kTracking.rise_neighbours && c[k].t_s - c[first - 1].t_s < kTracking.rise_around_s)
      --first;
    while (last + 1 < c.size() && last - k < kTracking.rise_neighbours &&
           c[last + 1].t_s - c[k].t_s < kTracking.rise_around_s)
      ++last;
    odds[k] = log(densities[k].event / densities[k].mixture(share_of_events(densities, first, last, k)));
  }
  return odds;
}

Observations::Observations(const std::vector<Candidate>& candidates, double timing_s, const SameSource& same_source,
                           double duration_s, std::optional<double> elastic_flight_s)
    : candidates_(candidates), same_source_(same_source), duration_s_(duration_s) {
  const std::vector<double> rise = log_rise_odds(candidates, kShortestWindow_s * kTracking.timing_samples / timing_s);
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const Candidate& c = candidates[k];
    const double sigma_s =
        c.reach_s < kTracking.sharp_s ? timing_s : std::max(timing_s, kTracking.timing_of_reach * c.reach_s);
    log_amplitudes_.push_back(log(c.amplitude));
    observations_.push_back({c.t_s, sigma_s, log_amplitudes_[k], rise[k], 0.0, {}, elastic_flight_s});
  }
  for (std::size_t k = 0; k < candidates.size(); ++k) observations_[k] = without(k, {});
}

Observation Observations::without(std::size_t k, const std::vector<std::size_t>& explained) const {
  Observation seen = observations_[k];
  seen.neighbours = count_neighbours(k, candidates_, log_amplitudes_, same_source_, explained);
  seen.neighbours.around_s =
      static_cast<float>(std::min(seen.t_s + kLargestReach_s, duration_s_) - std::max(0.0, seen.t_s - kLargestReach_s));
  seen.log_odds_of_first = kTracking.start_log_odds + seen.log_rise_odds - log_odds_against_first(seen.neighbours);
  return seen;
}

}  // namespace bouncelab::detection
