// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rise_odds.hpp"

#include <algorithm>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kAround = 24;  // candidates on either side
constexpr double kAround_s = 1.0;
constexpr double kPriorWeight = 4.0;  // candidates that the prior share of events is worth
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
    double sum = 0.5 * kPriorWeight;
    for (std::size_t j = first; j <= last; ++j)
      if (j != k) sum += share * densities[j].event / densities[j].mixture(share);
    share = sum / (kPriorWeight + static_cast<double>(last - first));
  }
  return share;
}

}  // namespace

std::vector<double> log_rise_odds(const std::vector<Candidate>& c, double n_in_window, const TrackingModel& model) {
  const double z0 = model.event_per_sample * n_in_window;
  const double excess = model.excess + model.excess_per_sample * n_in_window;
  std::vector<Densities> densities;
  for (const Candidate& candidate : c) {
    const double z = std::max(0.0, candidate.log_likelihood_ratio - kCandidateThreshold);
    densities.push_back({z0 / square(z0 + z), exp(-z / excess) / excess});
  }
  std::vector<double> odds(c.size());
  for (std::size_t k = 0; k < c.size(); ++k) {
    std::size_t first = k, last = k;
    while (first > 0 && k - first < kAround && c[k].t_s - c[first - 1].t_s < kAround_s) --first;
    while (last + 1 < c.size() && last - k < kAround && c[last + 1].t_s - c[k].t_s < kAround_s) ++last;
    odds[k] = log(densities[k].event / densities[k].mixture(share_of_events(densities, first, last, k)));
  }
  return odds;
}

}  // namespace bouncelab::detection
