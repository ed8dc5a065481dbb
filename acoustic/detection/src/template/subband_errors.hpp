// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "template/subband_delay.hpp"
#include "template/template_search.hpp"

namespace bouncelab::detection {

/// Sets the jitter variance of each sub-band by variance components: the squared deviations from the mean, corrected
/// for what the mean follows, minus those that noise explains. Each jitter is shrunk towards the median phase variance
/// of all sub-bands, since the deviations of one that dominates the mean are small whatever its jitter. Leaves all as
/// it is with fewer than three estimates or two sub-bands.
/// @param estimates  of many impacts of one recording
/// @param filter     that of the estimates
void estimate_jitter(const std::vector<DelayEstimate>& estimates, const MatchedFilter& filter, Subbands& subbands);

/// Sets each sub-band's noise: the variance in each real and imaginary part, averaged over its bins with the weights
/// omega^2 |W|^2 that the delay gives them. (A plain mean is wrong where the whitened noise is not flat within a
/// sub-band; and it is not flat where the whitener has modelled the modes too: it is low just where the template is
/// strong.) Estimated from the quieter half of the windows that end where those of the training impacts begin; in the
/// others an earlier impact still rings.
/// @return  sum of squares of such a window, averaged
double estimate_noise(TemplateEstimation& e);

/// Degrees of freedom of what varies from impact to impact, (tr C)^2 / tr C^2 with the covariance C of the residuals:
/// over such a number of directions their power is spread (Welch-Satterthwaite). The products of different residuals
/// estimate tr C^2 without bias. Between 2 and the length of a residual.
/// @param residuals  of equal length, each over the amplitude of its impact
double degrees_of_freedom(const std::vector<std::vector<float>>& residuals);

/// A single sub-band cannot disagree: of what neither template nor noise explains, the delay takes the share of one of
/// the directions that it is spread over. (Half of it, in quadrature, would be too much: a mode that is excited more or
/// less strongly keeps its phase.)
/// @param quiet  sum of squares of a window without impact
void add_unexplained_jitter(TemplateEstimation& e, double quiet);

}  // namespace bouncelab::detection
