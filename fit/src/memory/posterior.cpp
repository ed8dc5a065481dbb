// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kFreedom = 5.0;

/// R with R R^T the covariance, in whatever units.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  return whitening(gram(whitening(covariance, 1e-15)), 1e-12);
}

/// One round: draws about a centre, weighed by the density.
Posterior round_of(const LogDensity& log_density, const Eigen::VectorXd& centre, const Eigen::MatrixXd& spread,
                   std::size_t n, std::uint64_t seed, std::uint64_t round) {
  Posterior result;
  const Eigen::Index p = centre.size(), columns = static_cast<Eigen::Index>(n);
  result.draws.resize(p, columns);
  Eigen::VectorXd log_weight(columns);
  parallel_for(n, 0, [&](std::size_t k) {
    Random random(seed, RandomStream::bootstrap, (round << 32U) + k);
    Eigen::VectorXd z(p);
    double chi2 = 0.0;
    for (double& value : z) value = random.normal();
    for (int i = 0; i < static_cast<int>(kFreedom); ++i) chi2 += square(random.normal());
    const Eigen::VectorXd y = z / std::sqrt(chi2 / kFreedom);
    const auto column = static_cast<Eigen::Index>(k);
    result.draws.col(column) = centre + product(spread, y);
    const double log_proposal = -0.5 * (kFreedom + static_cast<double>(p)) * log1p(y.squaredNorm() / kFreedom);
    const double value = log_density(result.draws.col(column));
    log_weight[column] = std::isfinite(value) ? value - log_proposal : -HUGE_VAL;
  });
  const double highest = log_weight.maxCoeff();
  result.weights.resize(columns);
  for (Eigen::Index k = 0; k < columns; ++k) result.weights[k] = exp(log_weight[k] - highest);
  const double cut = result.weights.mean() * std::sqrt(static_cast<double>(n));
  result.weights = result.weights.cwiseMin(cut);
  result.weights /= result.weights.sum();
  result.effective = 1.0 / result.weights.squaredNorm();
  result.mean = product(result.draws, result.weights);
  const Eigen::MatrixXd about = result.draws.colwise() - result.mean;
  result.covariance = product(about * result.weights.asDiagonal(), about.transpose());
  return result;
}

}  // namespace

Interval interval_of(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double probability) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
  const auto quantile = [&](double level) {
    // each weight at its middle, linear between
    double sum = 0.0, before = 0.0, value_before = values[order.front()];
    for (const Eigen::Index k : order) {
      const double middle = sum + 0.5 * weights[k];
      if (middle >= level) {
        const double share = middle > before ? (level - before) / (middle - before) : 1.0;
        return value_before + share * (values[k] - value_before);
      }
      sum += weights[k];
      before = middle;
      value_before = values[k];
    }
    return value_before;
  };
  const double tail = 0.5 * (1.0 - probability);
  return {quantile(tail), quantile(1.0 - tail)};
}

Posterior normal_draws(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, std::size_t n_draws,
                       std::uint64_t seed) {
  Posterior result;
  const auto n = static_cast<Eigen::Index>(n_draws);
  result.mean = mean;
  result.covariance = covariance;
  result.effective = static_cast<double>(n_draws);
  result.weights = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n_draws));
  result.draws.resize(mean.size(), n);
  const Eigen::MatrixXd spread = root_of(covariance);
  for (Eigen::Index k = 0; k < n; ++k) {
    Random random(seed, RandomStream::bootstrap, (std::uint64_t{3} << 40U) + static_cast<std::uint64_t>(k));
    Eigen::VectorXd z(mean.size());
    for (double& value : z) value = random.normal();
    result.draws.col(k) = mean + product(spread, z);
  }
  // exactly the mean asked for: what is reported has no error of drawing
  const Eigen::VectorXd shift = product(result.draws, result.weights) - mean;
  result.draws.colwise() -= shift;
  return result;
}

Posterior sample_posterior(const LogDensity& log_density, const Eigen::VectorXd& centre,
                           const Eigen::MatrixXd& covariance, std::size_t n_draws, std::uint64_t seed) {
  constexpr int kMostRounds = 5;
  constexpr double kEnough = 0.15;  // of the draws: the round's mean and covariance are good enough to draw by
  Eigen::VectorXd about = centre;
  Eigen::MatrixXd spread = covariance;
  for (int round = 0; round < kMostRounds; ++round) {
    const Posterior here =
        round_of(log_density, about, root_of(spread), n_draws / 3, seed, static_cast<std::uint64_t>(round));
    const auto n = static_cast<double>(here.draws.cols());
    const double few = static_cast<double>(4 * about.size());
    about = here.mean;
    // of few effective draws the covariance is no guide: the old one, halved or doubled, shares
    const double trust = here.effective / (here.effective + few);
    spread = (trust * here.covariance + (1.0 - trust) * spread).eval();
    if (round > 0 && here.effective > kEnough * n) break;
  }
  return round_of(log_density, about, root_of(spread), n_draws, seed, kMostRounds);
}

}  // namespace bouncelab::fit
