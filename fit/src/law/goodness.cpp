// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/goodness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"
#include "law/distributions.hpp"

namespace bouncelab::fit {

std::optional<ChiSquare> pearson_chi2(const std::vector<double>& u, std::size_t n_parameters,
                                      std::size_t n_groups_most) {
  constexpr std::size_t kPerCell = 8;
  const std::size_t n = u.size();
  const std::size_t n_cells = std::clamp<std::size_t>(n / kPerCell, 1, n_groups_most > 1 ? 10 : 30);
  const std::size_t n_groups = std::clamp<std::size_t>(n / (n_cells * kPerCell), 1, n_groups_most);
  if (n_cells < 2) return std::nullopt;
  ChiSquare result;
  for (std::size_t g = 0; g < n_groups; ++g) {
    const std::size_t begin = g * n / n_groups, end = (g + 1) * n / n_groups;
    std::vector<double> counts(n_cells, 0.0);
    for (std::size_t k = begin; k < end; ++k) {
      const auto cell = static_cast<std::size_t>(std::clamp(u[k], 0.0, 1.0) * static_cast<double>(n_cells));
      counts[std::min(cell, n_cells - 1)] += 1.0;
    }
    const double expected = static_cast<double>(end - begin) / static_cast<double>(n_cells);
    for (const double c : counts) result.chi2 += (c - expected) * (c - expected) / expected;
  }
  const std::size_t n_free = n_groups * (n_cells - 1);
  result.ndf = n_free >= 10 * n_parameters ? n_free - n_parameters : n_free;
  result.p_value = chi2_survival(result.chi2, static_cast<double>(result.ndf));
  return result;
}

namespace {

double expected_distance(const LawLikelihood& likelihood, const ScatterModel& scatter, std::size_t k) {
  const double v = likelihood.data().v_mps[k], tau = hypot(likelihood.data().tau[k], scatter.normal(v));
  const double below = scatter.below(v), above = scatter.above(v);
  if (likelihood.scatter().kind == ScatterKind::normal) return std::sqrt(2.0 / std::numbers::pi) * hypot(below, tau);
  // root mean square distance turned into a mean one is exact for tau = 0 and within 6 % for tau >> b
  return hypot((below * below + above * above) / (below + above), tau * std::sqrt(2.0 / std::numbers::pi));
}

ResidualBin residual_bin(const LawLikelihood& likelihood, const Eigen::VectorXd& theta, const ScatterModel& scatter,
                         std::size_t begin, std::size_t end) {
  const LawData& data = likelihood.data();
  ResidualBin bin;
  bin.n = end - begin;
  bin.v_mps = data.v_mps[(begin + end) / 2];
  std::vector<double> residuals;
  double score = 0.0, information = 0.0, distance = 0.0, expected = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    const double d = data.eps[k] - likelihood.eps_of(theta, k);
    residuals.push_back(d);
    bin.mean_residual += d / static_cast<double>(bin.n);
    distance += std::abs(d);
    expected += expected_distance(likelihood, scatter, k);
    score += likelihood.density(theta, k).d_location;
  }
  const std::size_t middle = (begin + end) / 2;
  information = static_cast<double>(bin.n) * likelihood.information_of(theta, middle)(0, 0);
  bin.median_residual = upper_median(std::move(residuals));
  bin.pull = score / std::sqrt(information);
  bin.scatter_ratio = distance / expected;
  return bin;
}

}  // namespace

std::vector<ResidualBin> residual_bins(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  const std::size_t n = likelihood.data().size();
  const std::size_t n_bins = std::clamp<std::size_t>(n / 12, 1, 24);
  const ScatterModel scatter = likelihood.scatter_model(theta);
  std::vector<ResidualBin> bins;
  for (std::size_t j = 0; j < n_bins; ++j)
    bins.push_back(residual_bin(likelihood, theta, scatter, j * n / n_bins, (j + 1) * n / n_bins));
  return bins;
}

}  // namespace bouncelab::fit
