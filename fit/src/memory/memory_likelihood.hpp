// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "law/law_model.hpp"
#include "memory/chains.hpp"
#include "memory/filter.hpp"

namespace bouncelab::fit {

/// d eps / d q and d (d eps / d v) / d q at a chain's impacts, a column an impact.
struct LawRows {
  Eigen::MatrixXd eps, slope;
};

/// Log-likelihood of all chains: theta = (law's coordinates, log q, keep, log M, slip). M is the mean of the reservoir
/// before the first impact of the chain that begins earliest in its drop [m^2/s^2]: what the release left and what the
/// impacts before that one added, which needs not be known apart. It is free whether or not the release was clean.
class MemoryLikelihood {
 public:
  MemoryLikelihood(const Chains& chains, const LawModel& model);

  Eigen::Index n_parameters() const { return n_law_ + 3 + static_cast<Eigen::Index>(kSlipTimes); }
  Eigen::Index index_of_q() const { return n_law_; }
  Eigen::Index index_of_keep() const { return n_law_ + 1; }
  Eigen::Index index_of_first() const { return n_law_ + 2; }
  /// What balls at rest when released would have for M: 2 q S [m^2/s^2].
  double first_at_rest_m2ps2(double q) const { return 2.0 * q * chains_.least_s_before; }
  MemoryParameters<double> parameters(const Eigen::VectorXd& theta) const;

  /// What stays fixed until the next call, at theta. The likelihood is smooth near it.
  void plan_at(const Eigen::VectorXd& theta);
  /// With the log of the prior.
  double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const;
  /// Without the prior, with a plan of its own for each call: good everywhere, and slower by half.
  double anew(const Eigen::VectorXd& theta) const;
  /// Each slip is normal about 0: of the spin of a solid ball that is released with nothing else 2/7 is left when it
  /// rolls, and log(7/2) is the standard deviation. Log M is flat, up to four times the square of the first speed, and
  /// falls off as 1/(1 + (M0/M)^2) below M0 = first_at_rest_m2ps2(), which any release only adds to. Flat in the
  /// others.
  double log_prior(const Eigen::VectorXd& theta) const;
  Eigen::VectorXd prior_gradient(const Eigen::VectorXd& theta) const;
  /// By the curvature of slip and the square of the score of M, as of impacts.
  Eigen::MatrixXd prior_information(const Eigen::VectorXd& theta) const;
  /// Derivatives of each impact's log density given those before it by (law's coordinates, log q, keep, log M,
  /// slip, then what is tested: ratio, power), a column an impact: differences of a martingale, so the sum of
  /// their squares is an information matrix.
  Eigen::MatrixXd scores_by_impact(const Eigen::VectorXd& theta) const;
  /// Sums of them over the impacts of each drop.
  Eigen::MatrixXd by_drop(const Eigen::MatrixXd& scores_by_impact) const;
  /// Probability of less at every impact, given those before it, chain by chain.
  std::vector<double> transforms(const Eigen::VectorXd& theta) const;

  const Chains& chains() const { return chains_; }
  const LawModel& model() const { return model_; }

 private:
  template <class T>
  ChainFilter<T> filter(std::size_t chain, const MemoryParameters<T>& parameters) const {
    return {chains_.chains[chain], chains_.height_sd_m(parameters.q), parameters};
  }
  /// Of one chain: its log-likelihood, and the gradient or the rows of scores_by_impact() of its impacts.
  void score(std::size_t chain, const Eigen::VectorXd& theta, double& loglik, Eigen::VectorXd* gradient,
             Eigen::MatrixXd* by_impact) const;
  Eigen::VectorXd gradient_by_first(const Eigen::VectorXd& theta) const;
  double rest_over_first_squared(const Eigen::VectorXd& theta) const;
  std::vector<LawAt<double>> law_values(std::size_t chain, const Eigen::VectorXd& theta) const;

  const Chains& chains_;
  const LawModel& model_;
  Eigen::Index n_law_;
  std::vector<FilterPlan> plans_;
  std::vector<LawRows> linear_;  ///< rows of a linear model, by chain
};

}  // namespace bouncelab::fit
