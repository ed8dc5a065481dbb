// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/drop_rate.hpp"

#include <algorithm>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kStep = 2.0;  // of the rates that are averaged over

/// Windows with sounds enough for a track.
double n_windows(const std::vector<Candidate>& c) {
  double n = 0.0;
  for (std::size_t k = 0; k < c.size();) {
    const auto end = std::partition_point(c.begin() + static_cast<std::ptrdiff_t>(k), c.end(), [&](const Candidate& s) {
      return s.t_s < c[k].t_s + kTracking.birth_window_s;
    });
    const auto next = static_cast<std::size_t>(end - c.begin());
    if (std::ssize(c) > 0 && next - k >= static_cast<std::size_t>(kFewestImpacts)) n += 1.0;
    k = next;
  }
  return std::max(1.0, n);
}

/// log(1 - p + p odds)
double log_evidence(double p, double log_odds) { return log_of_sum(log(p) + log_odds, log1p(-p)); }

}  // namespace

void weigh_by_drop_rate(const std::vector<Candidate>& candidates, std::vector<Track>& tracks) {
  if (tracks.empty()) return;
  const double n = std::max(n_windows(candidates), static_cast<double>(tracks.size()));
  const double most = 1.0 / (1.0 + exp(-kTracking.start_log_odds));
  struct Rate {
    double log_odds;  // of a ball in a window
    double log_weight;
  };
  std::vector<Rate> rates;
  for (double p = most; p > most / n / kStep; p /= kStep) {
    double log_weight = (n - static_cast<double>(tracks.size())) * log1p(-p);
    for (const Track& track : tracks) log_weight += log_evidence(p, track.log_odds - kTracking.start_log_odds);
    rates.push_back({log(p) - log1p(-p), log_weight});
  }
  const double largest = std::max_element(rates.begin(), rates.end(), [](const Rate& a, const Rate& b) {
                           return a.log_weight < b.log_weight;
                         })->log_weight;
  for (Track& track : tracks) {
    double ball = 0.0, none = 0.0;
    for (const Rate& rate : rates) {
      const double log_odds = track.log_odds - kTracking.start_log_odds + rate.log_odds;
      const double weight = exp(rate.log_weight - largest);
      ball += weight / (1.0 + exp(-log_odds));
      none += weight / (1.0 + exp(log_odds));
    }
    // beyond what is not to be told from certainty, the largest rate has all the weight or the track needs none
    if (none > 1e-12 * ball) track.log_odds = log(ball / none);
  }
}

}  // namespace bouncelab::detection
