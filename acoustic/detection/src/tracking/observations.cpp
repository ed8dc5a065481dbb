// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/observations.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "candidates/candidates.hpp"

namespace bouncelab::detection {
namespace {

/// The nearest octave: that below sqrt(2) times as much.
int window_octave(double flight_s) {
  return std::clamp(std::ilogb(2.0 * std::numbers::sqrt2 / kSmallestReach_s * flight_s), 0, kWindowOctaves - 1);
}

constexpr double reach_s(int octave) { return kSmallestReach_s * static_cast<double>(1 << octave); }

/// 1 + 1/2 + ... + 1/n, between whole n as its asymptotic series; n >= 1.
double harmonic(double n) { return log(n) + 0.5772 + 0.5 / n; }

}  // namespace

Neighbours count_neighbours(std::size_t k, const std::vector<Candidate>& c, std::span<const double> log_amplitude,
                            const SameSource& same_source, const std::vector<std::size_t>& not_counted) {
  std::size_t first = k, end = k + 1;
  while (first > 0 && c[k].t_s - c[first - 1].t_s <= kLargestReach_s) --first;
  while (end < c.size() && c[end].t_s - c[k].t_s <= kLargestReach_s) ++end;
  std::vector<float> shares(end - first);
  same_source.weigh(k, first, shares);
  for (auto j = std::lower_bound(not_counted.begin(), not_counted.end(), first); j != not_counted.end() && *j < end;
       ++j)
    shares[*j - first] = 0.0F;
  shares[k - first] = 1.0F;
  Neighbours n;
  int octave = kWindowOctaves - 1;
  for (std::size_t j = first; j < end; ++j) {
    const double apart_s = std::abs(c[j].t_s - c[k].t_s);
    if (j != k && apart_s < kTracking.same_sound_s) continue;
    while (octave > 0 && apart_s <= reach_s(octave - 1)) --octave;  // up to k
    while (apart_s > reach_s(octave)) ++octave;                     // behind it
    const float share = shares[j - first];
    n.density[octave] += share * static_cast<float>(amplitude_kernel(log_amplitude[j] - log_amplitude[k]));
    n.all += share;
    n.stronger += log_amplitude[j] >= log_amplitude[k] ? share : 0.0F;
  }
  for (octave = 1; octave < kWindowOctaves; ++octave) n.density[octave] += n.density[octave - 1];
  return n;
}

double clutter_window_s(double flight_s) { return reach_s(window_octave(flight_s)); }

double clutter_intensity(const Neighbours& neighbours, double flight_s, double own) {
  const int octave = window_octave(flight_s);
  const double itself = amplitude_kernel(0.0);
  // where all others are the track's own, none is left
  const double density = std::max(0.0, neighbours.density[octave] - itself - own) + kTracking.unseen * itself;
  return density / (2.0 * reach_s(octave));
}

double clutter_intensity(const Neighbours& neighbours, double flight_s) {
  const int octave = window_octave(flight_s);
  const double itself = amplitude_kernel(0.0), prior = kTracking.unseen * itself;
  const auto others = [&](int o) { return std::max(0.0, neighbours.density[o] - itself); };
  const double around_s = neighbours.around_s;
  const double around = (others(kWindowOctaves - 1) + prior) / around_s;
  return (others(octave) + prior) / (std::min(2.0 * reach_s(octave), around_s) + prior / around);
}

double least_clutter_intensity(double flight_s) {
  return kTracking.unseen * amplitude_kernel(0.0) / (2.0 * clutter_window_s(flight_s));
}

double log_odds_against_first(const Neighbours& neighbours) {
  return log(neighbours.stronger * harmonic(std::max(1.0F, neighbours.all)));
}

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
