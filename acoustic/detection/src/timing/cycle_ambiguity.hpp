// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bouncelab::detection {

/// Log odds from which the sound alone decides.
inline constexpr double kUnambiguousLogOdds = 15.0;

/// A time at which an impact may have been.
struct DelayHypothesis {
  double t_s = 0.0;
  double log_odds_margin =
      0.0;  ///< log odds of the most likely place against this one, as the sound alone has them, >= 0
};

/// An impact of a train that may have been at one of several times, cycles of its wave apart.
struct ImpactHypotheses {
  std::int64_t impact = 0;
  std::vector<DelayHypothesis> places;  ///< the most likely first
};

struct CycleChoice {
  std::size_t place = 0;
  std::vector<double> log_odds_margin;  ///< log odds of the chosen against each place, sound and train together
};

/// Decides between the places by the smoothness of the train: ln(T_{k+1}/T_k) scatters about the median of its
/// neighbours like Student's t with four degrees of freedom, whose width the train shows itself. The most probable
/// sequence, by dynamic programming; the odds of each impact with its neighbours as chosen.
std::vector<CycleChoice> resolve_cycle_slips(const std::vector<ImpactHypotheses>& impacts);

}  // namespace bouncelab::detection
