// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/agreement.hpp"

#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "numerics/distributions.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {

UnitMeans unit_means(const UnitSamples& samples, const std::vector<std::size_t>& unit, std::size_t n_units) {
  constexpr double kIndependent = 1e-9;  // of the curve's own squares: less of it is left beside the means
  const Eigen::Index n_curve = samples.curve.cols();
  UnitMeans result{std::vector<double>(n_units, 0.0), std::vector<double>(n_units, 0.0)};
  Eigen::MatrixXd of_curve = Eigen::MatrixXd::Zero(n_curve, static_cast<Eigen::Index>(n_units));  // means of its rows
  for (std::size_t k = 0; k < unit.size(); ++k) {
    result.weight[unit[k]] += samples.weight[k];
    result.mean[unit[k]] += samples.weight[k] * samples.residual[k];
    of_curve.col(static_cast<Eigen::Index>(unit[k])) +=
        samples.weight[k] * samples.curve.row(static_cast<Eigen::Index>(k)).transpose();
  }
  for (std::size_t u = 0; u < n_units; ++u) {
    result.mean[u] /= result.weight[u];
    of_curve.col(static_cast<Eigen::Index>(u)) /= result.weight[u];
  }
  // the curve by what samples are off the means of their units
  Eigen::MatrixXd rows(samples.curve.rows(), n_curve);
  Eigen::VectorXd off(samples.curve.rows());
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(n_curve);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double root = std::sqrt(samples.weight[i]);
    scale += (root * samples.curve.row(k).transpose()).cwiseAbs2();
    rows.row(k) = root * (samples.curve.row(k) - of_curve.col(static_cast<Eigen::Index>(unit[i])).transpose());
    off[k] = root * (samples.residual[i] - result.mean[unit[i]]);
  }
  const Eigen::MatrixXd scaled = rows * scale.cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd products = transposed_product(scaled, scaled);
  const auto rank = static_cast<std::size_t>((eigenvalues(products).array() > kIndependent).count());
  // directions that the units leave nothing of stay where they are
  const Eigen::MatrixXd ridge = 1e-12 * Eigen::MatrixXd::Identity(n_curve, n_curve);
  const Eigen::VectorXd q = cholesky(products + ridge)->solve(transposed_product(scaled, off));
  result.squares = (off - product(scaled, q)).squaredNorm();
  const Eigen::VectorXd moved =
      transposed_product(scale.cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal() * of_curve, q);
  for (std::size_t u = 0; u < n_units; ++u) result.mean[u] -= moved[static_cast<Eigen::Index>(u)];
  const std::size_t taken = n_units + rank;
  result.n_free = unit.size() > taken ? unit.size() - taken : 0;
  return result;
}

std::optional<Agreement> agreement(const UnitSamples& samples) {
  constexpr std::size_t kFewestBetweenDrops = 10;  // degrees of freedom; below, F would have next to no power
  const std::size_t n = samples.residual.size();
  if (samples.n_groups < 2 || n == 0) return std::nullopt;
  const UnitMeans one = unit_means(samples, std::vector<std::size_t>(n, 0), 1);
  const UnitMeans groups = unit_means(samples, samples.group, samples.n_groups);
  const UnitMeans drops = unit_means(samples, samples.drop, samples.n_drops);
  if (groups.n_free >= one.n_free || groups.n_free == 0) return std::nullopt;
  Agreement result;
  RecordingsTest& test = result.test;
  test.n_recordings = samples.n_groups;
  test.ndf = static_cast<double>(one.n_free - groups.n_free);
  double squares_within = groups.squares;
  test.ndf_within = static_cast<double>(groups.n_free);
  if (groups.n_free >= drops.n_free + kFewestBetweenDrops && drops.n_free > 0) {
    test.within = WithinUnit::drops;
    squares_within = std::max(0.0, groups.squares - drops.squares);
    test.ndf_within = static_cast<double>(groups.n_free - drops.n_free);
  }
  const double between = std::max(0.0, one.squares - groups.squares);
  test.f = between / test.ndf / (squares_within / test.ndf_within);
  test.p_value = f_survival(test.f, test.ndf, test.ndf_within);
  test.likelihood_ratio = static_cast<double>(n) * log(one.squares / groups.squares);
  double mean = 0.0;
  for (const std::size_t g : samples.group) mean += groups.mean[g] / static_cast<double>(n);
  const double variance = groups.squares / static_cast<double>(groups.n_free);
  for (std::size_t g = 0; g < samples.n_groups; ++g)
    result.offsets.push_back(normal_estimate(groups.mean[g] - mean, std::sqrt(variance / groups.weight[g])));
  return result;
}

}  // namespace bouncelab::fit
