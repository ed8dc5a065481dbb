// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/fit.hpp"

namespace bouncelab::report {

/// Something that the paper concludes from its figures, put to the numbers of one experiment.
struct Conclusion {
  std::string claim;                  ///< "p(eps) is not normal"
  std::string measure;                ///< what `value` is
  std::optional<double> value;        ///< absent where the data do not reach
  std::optional<fit::Interval> ci95;  ///< of `value`, where it has one
  std::string criterion;              ///< when the claim is said to hold
  bool holds = false;
  std::string detail;  ///< the numbers behind, in words
};
Description members_of(const Conclusion*);

/// What Montaine et al., doi:10.1103/PhysRevE.84.041306, conclude from their figs. 1 and 2:
///   - p(eps) at fixed speed is not normal          every window: AIC(normal) - AIC(two exponentials) > 10
///   - its two slopes differ                        every window: 95 % interval of their ratio excludes 1
///   - its peaks follow eps(v)                      every window: |peak - eps(v)| < 3 standard errors
///   - the scatter comes from the asperities        spread of the smooth ball below a tenth of the rough ball's
///   - it grows as the speed falls                  95 % interval of k in spread ~ v^k below 0
/// @param rough   fitted to the rough ball
/// @param smooth  fitted to the same ball without asperities through the same chain; without: that claim is left out
/// @param truth   the law that went in, where it is known; else the peaks are held against the fitted law
std::vector<Conclusion> paper_conclusions(const fit::FitResult& rough, const fit::FitResult* smooth,
                                          const std::optional<RestitutionLaw>& truth);

}  // namespace bouncelab::report
