// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/goodness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"
#include "law/columns.hpp"
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

/// Expected distances of the samples from the curve.
std::vector<double> expected_distances(const LawLikelihood& likelihood, const ScatterModel& scatter) {
  const LawData& data = likelihood.data();
  const ScaleColumns b = scales_at(scatter, data.v_mps);
  const double of_normal = std::sqrt(2.0 / std::numbers::pi);
  std::vector<double> expected(data.size());
  for (std::size_t k = 0; k < data.size(); ++k) {
    const double below = b.below[k], above = b.above[k];
    const double tau = hypot(data.tau[k], scatter.normal_ratio * std::sqrt(below * above));
    // root mean square distance turned into a mean one is exact for tau = 0 and within 6 % for tau >> b
    expected[k] = likelihood.scatter().kind == ScatterKind::normal
                      ? of_normal * hypot(below, tau)
                      : hypot((below * below + above * above) / (below + above), tau * of_normal);
  }
  return expected;
}

}  // namespace

std::vector<ResidualBin> residual_bins(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  const std::size_t n = likelihood.data().size();
  const std::size_t n_bins = std::clamp<std::size_t>(n / 12, 1, 24);
  const LawLikelihood::Derivatives of = likelihood.derivatives(theta);
  const std::vector<double> expected_distance = expected_distances(likelihood, likelihood.scatter_model(theta));
  std::vector<ResidualBin> bins;
  for (std::size_t j = 0; j < n_bins; ++j) {
    const std::size_t begin = j * n / n_bins, end = (j + 1) * n / n_bins, middle = (begin + end) / 2;
    ResidualBin bin;
    bin.n = end - begin;
    bin.v_mps = likelihood.data().v_mps[middle];
    double score = 0.0, distance = 0.0, expected = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      bin.mean_residual += of.residual[k] / static_cast<double>(bin.n);
      distance += std::abs(of.residual[k]);
      expected += expected_distance[k];
      score += of.by_location[k];
    }
    bin.median_residual = upper_median({of.residual.begin() + static_cast<std::ptrdiff_t>(begin),
                                        of.residual.begin() + static_cast<std::ptrdiff_t>(end)});
    bin.pull = score / std::sqrt(static_cast<double>(bin.n) * likelihood.information_of(theta, middle)(0, 0));
    bin.scatter_ratio = distance / expected;
    bins.push_back(bin);
  }
  return bins;
}

}  // namespace bouncelab::fit
