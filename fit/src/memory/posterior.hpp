// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "memory/memory_likelihood.hpp"

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

/// Probability that a standard normal is farther from 0.
double two_sided(double z);

/// Score test of one more parameter at its value if the model holds: its score less what the others explain of it, over
/// its standard error; by how drops differ from 10 drops on (Student's t), else by the scores of all impacts.
/// @param scores  by impact, a column each; rows: the n_fitted parameters that were fitted first, then others
MemoryTest score_test(const MemoryLikelihood& likelihood, const Eigen::MatrixXd& scores, Eigen::Index tested);

/// Does the model hold? Against samples drawn from it.
struct ModelTests {
  AndersonDarling anderson_darling;
  DropsTest between_drops;
  /// Of the scores of what is tested: probability that a sample's is as far from their mean. None where impacts are so
  /// many that the scores are normal.
  std::optional<std::array<double, kTestedParameters>> score_p;
};

/// Mean square of the drops' scores over what the scores of their impacts make it, over all directions of what was
/// fitted: 1 but for chance where all drops have the same parameters (information matrix test: White, Econometrica 50,
/// 1 (1982), doi:10.2307/1912526). 0 of one drop.
/// @param scores       of what was fitted, by impact
/// @param information  of what was fitted, by impacts
double drops_over_impacts(const MemoryLikelihood& likelihood, const Eigen::MatrixXd& scores,
                          const Eigen::MatrixXd& information);

/// Anderson-Darling on the probability transforms of up to 4,000 impacts (whole chains, evenly chosen), against samples
/// drawn from the model; each has the parameters that one step of scoring finds for it. Drops' scores of the same
/// impacts.
/// @param information  of all impacts about theta
/// @param z            of the score tests
ModelTests tests_by_drawing(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
                            const Eigen::MatrixXd& information, const std::array<double, kTestedParameters>& z,
                            std::size_t n_replicates, std::uint64_t seed);

}  // namespace bouncelab::fit
