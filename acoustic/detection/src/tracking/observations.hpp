// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"
#include "tracking/bounce_model.hpp"
#include "tracking/clutter.hpp"

namespace bouncelab::detection {

/// The candidates of a recording as the model of trains sees them. Refers to what it is made from.
struct HeardSounds {
  const std::vector<Candidate>& candidates;
  const std::vector<BandEnergies>& band_energies;  ///< or none
  double timing_s = 0.0;                           ///< error of times noticed by the shortest window
  std::vector<Rivals> rivals;
  std::vector<double> log_amplitude;
  std::vector<double> log_rise_odds;
  std::vector<double> log_odds_first;

  HeardSounds(const std::vector<Candidate>& candidates, double timing_s,
              const std::vector<BandEnergies>& band_energies);
  HeardSound heard(std::size_t k) const;
  /// Probability that two are of one kind; absent where there are no band_energies.
  std::optional<double> alike(std::size_t j, std::size_t k) const;
};

}  // namespace bouncelab::detection
