// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/maximise.hpp"

namespace bouncelab::fit {

/// Turns the maximum of the likelihood into what LawFit reports: parameters with errors, nodes, curve, goodness,
/// status.
void describe_fit(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum,
                  const std::vector<double>& node_speeds_mps, IntervalMethod intervals);

}  // namespace bouncelab::fit
