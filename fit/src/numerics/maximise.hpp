// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

namespace bouncelab::fit {

/// Log-likelihood at x; its gradient where asked for. Not finite: outside the domain.
using LogLikelihood = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd* gradient)>;

struct Maximum {
  Eigen::VectorXd x;
  double loglik = 0.0;
  /// What a quadratic model says is still to be gained, g^T I^-1 g / 2: below 1e-4 the estimate is within a hundredth
  /// of its standard error.
  double gain_left = 0.0;
  int n_evaluations = 0;
  bool converged = false;
};

/// Maximises by Ceres' BFGS with a Wolfe line search, in coordinates whitened by the information matrix at the start:
/// there the surface is nearly a unit bowl, whatever the units and correlations of x.
/// @param information  at the start; directions it says nothing about are searched with a bounded step
/// @param tolerance    on the whitened gradient: distance to the maximum in standard errors
Maximum maximise(const LogLikelihood& loglik, const Eigen::VectorXd& start, const Eigen::MatrixXd& information,
                 double tolerance = 2e-3);

}  // namespace bouncelab::fit
