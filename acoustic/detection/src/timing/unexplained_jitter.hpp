// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/template_alignment.hpp"

namespace bouncelab::detection {

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
