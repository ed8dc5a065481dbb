// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/memory_tests.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/by_drop.hpp"
#include "law/distributions.hpp"
#include "law/maximise.hpp"
#include "law/replicates.hpp"
#include "memory/memory_draws.hpp"

namespace bouncelab::fit {
namespace {

/// Impacts that the test is made of at most.
constexpr std::size_t kMostImpacts = 4000;

double statistic(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta) {
  return anderson_darling(likelihood.transforms(theta));
}

}  // namespace

double two_sided(double z) { return erfc(std::abs(z) * 0.70710678118654752); }

MemoryTest score_test(const MemoryLikelihood& likelihood, const Eigen::MatrixXd& scores, Eigen::Index tested) {
  const Eigen::MatrixXd fitted = scores.topRows(likelihood.n_parameters());
  const Eigen::VectorXd own = scores.row(tested).transpose();
  const Eigen::VectorXd of_fitted = (fitted * fitted.transpose()).ldlt().solve(fitted * own);
  const Eigen::MatrixXd rest = own.transpose() - of_fitted.transpose() * fitted;
  const Eigen::MatrixXd by_drop = likelihood.by_drop(rest);
  const auto n = static_cast<double>(by_drop.cols());
  const bool enough = likelihood.chains().n_drops >= kFewestDrops;
  const double variance = enough ? by_drop.squaredNorm() * n / (n - 1.0) : rest.squaredNorm();
  MemoryTest test;
  if (!(variance > 0.0)) return test;
  test.z = rest.sum() / std::sqrt(variance);
  test.p_value = enough ? 2.0 * student_t_below(-std::abs(test.z), n - 1.0) : two_sided(test.z);
  return test;
}

ModelTests tests_by_drawing(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
                            const Eigen::MatrixXd& information, double mechanism_z, std::size_t n_replicates,
                            std::uint64_t seed) {
  const Chains design = thinned_chains(likelihood.chains(), kMostImpacts);
  const LawModel& model = likelihood.model();
  const RestitutionLaw law = model.law(theta.head(model.n_parameters()));
  const MemoryParameters<double> parameters = likelihood.parameters(theta);
  // what a step finds has the error of all impacts, of which those of the design are a share
  const double share = static_cast<double>(design.n_impacts) / static_cast<double>(likelihood.chains().n_impacts);
  const double height_sd_m = design.height_sd_m(parameters.q);
  const Eigen::MatrixXd white = whitening(information, 1e-9);

  ModelTests tests;
  AndersonDarling& result = tests.anderson_darling;
  result.a2 = statistic(MemoryLikelihood(design, model), theta);
  result.n_replicates = n_replicates;
  std::vector<double> a2(n_replicates, 0.0), z(n_replicates, 0.0);
  parallel_for(n_replicates, 0, [&](std::size_t i) {
    Random random(seed, RandomStream::bootstrap, (std::uint64_t{2} << 32U) + i);
    Chains drawn = design;
    for (Chain& chain : drawn.chains) chain = draw_chain(chain, law, parameters, height_sd_m, random);
    MemoryLikelihood again(drawn, model);
    again.plan_at(theta);
    const Eigen::MatrixXd scores = again.scores_by_impact(theta);
    const Eigen::VectorXd score = scores.topRows(theta.size()).rowwise().sum();
    z[i] = score_test(again, scores, scores.rows() - 1).z;
    Eigen::VectorXd others(theta.size());
    for (double& x : others) x = random.normal();
    const Eigen::VectorXd in_white = white.transpose() * score + std::sqrt(1.0 - share) * others;
    a2[i] = statistic(again, theta + white * in_white);
  });
  const auto n_larger = std::count_if(a2.begin(), a2.end(), [&](double x) { return !(x < result.a2); });
  result.p_value = (1.0 + static_cast<double>(n_larger)) / (1.0 + static_cast<double>(n_replicates));
  if (design.n_impacts == likelihood.chains().n_impacts) {
    // of few drops the score is neither normal nor about zero
    const double mean = std::accumulate(z.begin(), z.end(), 0.0) / static_cast<double>(n_replicates);
    const auto n_farther = std::count_if(
        z.begin(), z.end(), [&](double x) { return !(std::abs(x - mean) < std::abs(mechanism_z - mean)); });
    tests.mechanism_p = (1.0 + static_cast<double>(n_farther)) / (1.0 + static_cast<double>(n_replicates));
  }
  return tests;
}

}  // namespace bouncelab::fit
