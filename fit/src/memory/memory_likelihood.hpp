// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "law/law_model.hpp"
#include "memory/chains.hpp"
#include "memory/filter.hpp"

namespace bouncelab::fit {

inline constexpr int kMostMemoryLawParameters = 5;

/// Log-likelihood of all chains: theta = (law's coordinates, log q, keep[, release in m^2/s^2]).
class MemoryLikelihood {
 public:
  /// @param with_release  whether the mean reservoir at the release is a parameter; else it is empty
  MemoryLikelihood(const Chains& chains, const LawModel& model, bool with_release);

  Eigen::Index n_parameters() const { return n_law_ + (with_release_ ? 3 : 2); }
  Eigen::Index index_of_q() const { return n_law_; }
  Eigen::Index index_of_keep() const { return n_law_ + 1; }
  Eigen::Index index_of_release() const { return n_law_ + 2; }
  MemoryParameters<double> parameters(const Eigen::VectorXd& theta) const;

  /// What stays fixed until the next call, at theta. The likelihood is smooth near it.
  void plan_at(const Eigen::VectorXd& theta);
  double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const;
  /// With a plan of its own for each call: good everywhere, and slower by half.
  double anew(const Eigen::VectorXd& theta) const;
  /// Derivatives of each impact's log density given those before it by (law's coordinates, log q, keep, release,
  /// log ratio), a column an impact: differences of a martingale, so the sum of their squares is an information matrix.
  Eigen::MatrixXd scores_by_impact(const Eigen::VectorXd& theta) const;
  /// Sums of them over the impacts of each drop.
  Eigen::MatrixXd by_drop(const Eigen::MatrixXd& scores_by_impact) const;
  /// Probability of less at every impact, given those before it, chain by chain.
  std::vector<double> transforms(const Eigen::VectorXd& theta) const;

  const Chains& chains() const { return chains_; }
  const LawModel& model() const { return model_; }

 private:
  struct LawRows {
    Eigen::RowVectorXd eps, slope;       ///< an entry an impact
    Eigen::MatrixXd eps_row, slope_row;  ///< a column an impact
  };
  template <class T>
  ChainFilter<T> filter(std::size_t chain, const MemoryParameters<T>& parameters) const {
    return {chains_.chains[chain], chains_.height_sd_m(parameters.q), parameters};
  }
  template <int N>
  void score(std::size_t chain, const Eigen::VectorXd& theta, double& loglik, Eigen::VectorXd* gradient,
             Eigen::MatrixXd* by_impact) const;
  LawRows law_rows(std::size_t chain, const Eigen::VectorXd& theta) const;
  std::vector<LawAt<double>> law_values(std::size_t chain, const Eigen::VectorXd& theta) const;

  const Chains& chains_;
  const LawModel& model_;
  Eigen::Index n_law_;
  bool with_release_;
  std::vector<FilterPlan> plans_;
  std::vector<LawRows> linear_;  ///< rows of a linear model, by chain
};

}  // namespace bouncelab::fit
