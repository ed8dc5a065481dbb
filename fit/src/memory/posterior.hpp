// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Log of a density of x, up to a constant; called from several threads. Not finite: outside the domain.
using LogDensity = std::function<double(const Eigen::VectorXd& x)>;

/// Weighted draws from a density.
struct Posterior {
  Eigen::MatrixXd draws;    ///< a column a draw
  Eigen::VectorXd weights;  ///< sum 1
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  double effective = 0.0;  ///< draws that would say as much if all weighed the same: 1 / sum of squares
};

/// Ends that leave out (1 - probability) / 2 of the weights on either side.
Interval interval_of(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double probability);

/// Draws of one normal distribution, all of the same weight.
Posterior normal_draws(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, std::size_t n_draws,
                       std::uint64_t seed);

/// Adaptive importance sampling: Student's t of 5 degrees of freedom about the mean and covariance of the round before,
/// until these stand. Weights above the mean times sqrt(n) are cut there (Ionides, J. Comput. Graph. Stat. 17, 295
/// (2008), doi:10.1198/106186008X320456). Source: Cappe, Guillin, Marin & Robert, ibid. 13, 907 (2004),
/// doi:10.1198/106186004X12803.
/// @param centre, covariance  a first guess; the result forgets it
/// @param n_draws             of the last round; earlier ones have a third
Posterior sample_posterior(const LogDensity& log_density, const Eigen::VectorXd& centre,
                           const Eigen::MatrixXd& covariance, std::size_t n_draws, std::uint64_t seed);

}  // namespace bouncelab::fit
