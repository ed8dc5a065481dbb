// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/samples.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {

/// Slip at the contact dies out by a constant factor an impact, which is not known: sums of two decays, of these
/// numbers of impacts, are near to all those from one half to 0.95.
inline constexpr std::size_t kSlipTimes = 2;
inline constexpr std::array<double, kSlipTimes> kSlipTime{2.0, 12.0};

/// One impact as measured. Speeds are half of g times an interval (less what was corrected for).
struct ChainImpact {
  std::size_t sample = 0;      ///< which of the samples
  double v_mps = 0.0;          ///< speed before it
  double v_after_mps = 0.0;    ///< eps v
  double timing_before = 0.0;  ///< variance of g/2 times the error of the time of the impact before [m^2/s^2]
  double timing = 0.0;         ///< of this impact
  double timing_after = 0.0;   ///< of the next
  double height_mps = 0.0;     ///< g h / (2 v) for a height h of 1 m: what a contact's height does to speeds [1/s]
  std::array<double, kSlipTimes> soon{};  ///< share of each decay that falls on this impact; all of a drop: 1
};

/// Successive impacts of one drop, none missing between them.
struct Chain {
  std::vector<ChainImpact> impacts;
  std::size_t drop = 0;  ///< number of its drop, from 0
  /// Sum of (1 + e)^2 v^2 over the drop's impacts before the first of the chain, seen or not [m^2/s^2].
  double s_before = 0.0;
};

struct Chains {
  std::vector<Chain> chains;
  std::size_t n_drops = 0;
  std::size_t n_impacts = 0;
  double least_s_before = 0.0;  ///< of all chains, also of those that thinned_chains() leaves out [m^2/s^2]
  Ball ball;                    ///< that of the first sample; the paper's where none is named

  /// Standard deviation of the heights of contacts, R s2: as if without slip [m].
  template <class T>
  T height_sd_m(const T& q) const {
    return ball.radius_m * (1.0 + ball.inertia_factor) * q;
  }
};

/// Cuts the samples of each drop where one is missing or left out; impact 0, which a ball meets at rest, is.
/// @param samples   ordered by recording, drop, time
/// @param left_out  samples that are more likely lost bounces than scatter, rising
/// @param law       for speeds of impacts that were not seen
Chains chains_of(const RestitutionSamples& samples, const std::vector<std::size_t>& left_out,
                 const RestitutionLaw& law);

/// Every n-th chain, so that there are at most about n_most impacts.
Chains thinned_chains(const Chains& all, std::size_t n_most);

}  // namespace bouncelab::fit
