// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/onsets.hpp"

namespace bouncelab::detection {

/// Detected against true impact times.
struct OnsetScore {
  std::size_t n_true = 0;
  std::size_t n_found = 0;     ///< true impacts with a detected one within the tolerance, one to one
  std::size_t n_missed = 0;    ///< true impacts without
  std::size_t n_invented = 0;  ///< detected impacts without a true one
  /// Median of (detected - true), a constant latency, which cancels in intervals [s]. Absent without a match.
  std::optional<double> offset_s;
  std::optional<double> rms_s;  ///< root mean square of the errors about the offset [s]
  /// The same about the median error of each drop, which also cancels in its intervals [s].
  std::optional<double> rms_within_drops_s;
  /// sqrt(chi2 / ndf) of the errors over their sigma_t, over matches that state one; 1 if the standard errors are
  /// right. What sigma_t excludes is fitted to each drop and subtracted: a constant and, from six impacts on, a
  /// multiple of v^(-1/5) (the contact law; v from the true flight before).
  std::optional<double> pull_sd;
  std::vector<std::optional<std::size_t>> match;  ///< for each true impact, the index of its detected one
};
Description members_of(const OnsetScore*);

/// Matches detected to true times one to one, nearest pairs first. Both may hold several recordings; times of different
/// recordings are never matched.
/// @param tolerance_s  > 0; largest distance of a match [s]. At most half the shortest interval.
/// Assumes that any constant latency is below the tolerance.
/// @throws InvalidArgument where tolerance_s is not above 0
OnsetScore score_onsets(const Onsets& truth, const Onsets& detected, double tolerance_s = 1e-3);

}  // namespace bouncelab::detection
