// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/observations.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kSharp_s = 1.8e-3;  // reach of the shortest window at 4 kHz and more; at 1 kHz all are longer
constexpr double kWindow_s = 0.8e-3;
constexpr double kTimingOfReach = 0.15;

}  // namespace

HeardSounds::HeardSounds(const std::vector<Candidate>& c, double timing, const std::vector<BandEnergies>& t)
    : candidates(c), band_energies(t), timing_s(timing), rivals(count_rivals(c, t)) {
  for (const Candidate& candidate : c) log_amplitude.push_back(log(candidate.amplitude));
  log_rise_odds = detection::log_rise_odds(c, kWindow_s / timing);
  for (std::size_t k = 0; k < c.size(); ++k) log_odds_first.push_back(log_odds_of_first(rivals[k], log_rise_odds[k]));
}

HeardSound HeardSounds::heard(std::size_t k) const {
  // what the shortest window has noticed is timed by a sample, what the longer ones have, by a part of themselves
  const double reach_s = candidates[k].reach_s;
  const double sigma_s = reach_s < kSharp_s ? timing_s : std::max(timing_s, kTimingOfReach * reach_s);
  return {candidates[k], rivals[k], sigma_s, log_amplitude[k], log_rise_odds[k], log_odds_first[k], {}, true};
}

std::optional<double> HeardSounds::alike(std::size_t j, std::size_t k) const {
  if (band_energies.empty()) return {};
  return same_source_probability(band_energies[j], band_energies[k]);
}

}  // namespace bouncelab::detection
