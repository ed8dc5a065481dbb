// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "delay/ringing.hpp"
#include "template/impact_template.hpp"

namespace bouncelab::detection {

/// A place where an impact may be.
struct PossiblePlace {
  double t_s = 0.0;
  double most_log_likelihood_ratio = 0.0;  ///< what an impact there may have, against none, noise variance 1
};

/// An impact that a place is not to be.
struct ImpactBeside {
  double log_likelihood_ratio = 0.0;
  double apart = 0.0;  ///< of the places from it, at least [samples]
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
  /// @param beside  an impact in the stretch; places are wanted that are none of its own
  std::vector<PossiblePlace> find(Ringing& known, double rate_hz, std::int64_t first, std::int64_t n_lags, double least,
                                  const ImpactBeside& beside);

 private:
  /// Most that a place may have beside an impact of amplitude A. With w the template there and w' at the place, the
  /// sound is A w + r, and by Schwarz' inequality, |.| the root of the energy,
  ///
  ///   <w', sound> <= (A <w', w>) + |w'| |r|,   LLR' <= (c sqrt(2 LLR) + |r|)^2 / 2,   |r|^2 = |sound|^2 - 2 LLR
  ///
  /// with c the largest correlation of the template with itself so far apart.
  double most_beside(const ImpactBeside& beside, double energy) const;

  const ImpactTemplate& learned_;
  audio::RealFft fourier_;
  std::int64_t begin_;  // of the template in the longer window: shifts are then about 0
  MatchedFilter filter_;
  double between_steps_ = 1.0;  // most that the likelihood is above that at the nearest step
  std::vector<float> alike_;    // correlation of the template with itself so many half samples later, or later still
};

}  // namespace bouncelab::detection
