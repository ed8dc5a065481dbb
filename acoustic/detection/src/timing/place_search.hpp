// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "timing/impact_template.hpp"
#include "timing/ringing.hpp"

namespace bouncelab::detection {

/// A place where an impact may be.
struct PossiblePlace {
  double t_s = 0.0;
  double most_log_likelihood_ratio = 0.0;  ///< what an impact there may have, against none, noise variance 1
};

/// Local maxima of the cross-correlation with the template over a stretch many times as long as the search about one
/// impact: by transforms of twice the window, each of which holds the template whole at as many places as the window
/// has samples or more.
class PlaceSearch {
 public:
  /// @param learned  kept by reference
  explicit PlaceSearch(const ImpactTemplate& learned);

  /// The places of whose first samples the template begins at one of n_lags, by blocks and in each the most likely
  /// first, at most eight. A block whose energy is too little (Schwarz' inequality) is not transformed.
  /// @param known   whose sound is subtracted
  /// @param least   log likelihood ratio that a place must be able to exceed
  std::vector<PossiblePlace> find(Ringing& known, double rate_hz, std::int64_t first, std::int64_t n_lags,
                                  double least);

 private:
  const ImpactTemplate& learned_;
  audio::RealFft fourier_;
  std::int64_t begin_;  // of the template in the longer window: shifts are then about 0
  MatchedFilter filter_;
  double between_steps_ = 1.0;  // most that the likelihood is above that at the nearest step
};

}  // namespace bouncelab::detection
