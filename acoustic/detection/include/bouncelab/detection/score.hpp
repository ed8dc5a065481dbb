// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/core/onsets.hpp"

namespace bouncelab::detection {

/// How a detector did against known times.
struct OnsetScore {
  std::size_t n_true = 0;
  std::size_t n_found = 0;     ///< true impacts with a detected one within the tolerance, one to one
  std::size_t n_missed = 0;    ///< true impacts without
  std::size_t n_invented = 0;  ///< detected impacts that belong to no true one
  /// Median of (detected - true): a constant latency, which intervals do not see [s]. Absent without a match.
  std::optional<double> offset_s;
  std::optional<double> rms_s;  ///< root mean square of the errors about the offset [s]
  /// The same with each drop's own median error taken out: what the intervals of a drop see [s].
  std::optional<double> rms_within_drops_s;
  /// Root of chi2 / ndf of the errors over their sigma_t, over matches that state a sigma; 1 for honest standard
  /// errors. What sigma_t leaves out since no interval sees it is taken out of each drop: a weighted mean and, from six
  /// impacts on, a weighted multiple of v^(-1/5) (the contact law; v from the true flight before).
  std::optional<double> pull_sd;
  std::vector<std::optional<std::size_t>> match;  ///< for each true impact, the index of its detected one
};

/// Matches detected to true times one to one, nearest pairs first. Both may hold several recordings; times of different
/// recordings are never matched.
/// @param tolerance_s  > 0; largest distance of a match [s]. Half the shortest interval to be told apart, or less.
/// Expects any constant latency to be below the tolerance.
OnsetScore score_onsets(const Onsets& truth, const Onsets& detected, double tolerance_s = 1e-3);

}  // namespace bouncelab::detection
