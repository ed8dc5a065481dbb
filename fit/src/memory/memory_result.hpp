// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "bouncelab/fit/memory_fit.hpp"
#include "memory/memory_likelihood.hpp"

namespace bouncelab::fit {

/// Fills in what the parameters say, how well they are known, and whether the model may be believed.
/// @param theta   where the likelihood has its maximum and its plan
/// @param scores  scores_by_impact() there
/// @param speeds  of all samples [m/s]
void describe(MemoryFit& fit, const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
              const Eigen::MatrixXd& scores, const MemoryFitConfig& config, const std::vector<double>& speeds);

}  // namespace bouncelab::fit
