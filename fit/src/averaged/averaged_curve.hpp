// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// Where drag and contact time are, by samples and priors together.
struct DeviationEstimate {
  Deviation mean, sd;
  bool is_ideal = false;  ///< there are none, more likely than not
};

/// eps(v) at some speeds, from fits of several laws on a grid of drag and contact time. A fit counts as the prior of
/// its place on the grid times the law's evidence, with the likelihood of the ratios T'/T as they were measured; what
/// is reported are quantiles of the sum of all fits' Student distributions. Between places of the grid everything is
/// interpolated; where samples know a parameter better than the grid resolves, the grid closes in on it.
///
/// Laws: one eps for all speeds, a straight one in ln v, the same with a step where there may be one, gamma, the
/// series, and of what yields a straight one in v^(-1/4) and the series; that alone which is asked for, where it is not
/// the default. Source of the weights: Kass & Raftery, J. Am. Stat. Assoc. 90, 773 (1995),
/// doi:10.1080/01621459.1995.10476572.
/// @param samples  with what their intervals hold, without outliers; at least 1
/// @param node_speeds_mps  empty: as LawFitConfig
/// @param estimate  gets where drag and contact time are
/// @return absent where no law can be fitted
std::optional<Curve> averaged_curve(const RestitutionSamples& samples, const AirAndContact& known,
                                    const LawFitConfig& config, std::vector<double> node_speeds_mps,
                                    DeviationEstimate& estimate);

/// The laws are of the peak of the scatter: the curve as root mean square instead.
/// @param law      with the shape of the scatter
/// @param scatter  of eps about a smooth curve: of few samples a law may pass them by, and the scatter about it is
/// larger
void to_mean_square(Curve& curve, const LawFit& law, double scatter);

}  // namespace bouncelab::fit
