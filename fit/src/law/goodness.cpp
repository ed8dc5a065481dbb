// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/goodness.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {

std::optional<ChiSquareTest> pearson_chi2(const std::vector<double>& u, std::size_t n_parameters,
                                          std::size_t n_groups_most) {
  constexpr std::size_t kPerCell = 8;
  const std::size_t n = u.size();
  const std::size_t n_cells = std::clamp<std::size_t>(n / kPerCell, 1, n_groups_most > 1 ? 10 : 30);
  const std::size_t n_groups = std::clamp<std::size_t>(n / (n_cells * kPerCell), 1, n_groups_most);
  if (n_cells < 2) return std::nullopt;
  ChiSquareTest result;
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
  result.ndf = static_cast<double>(n_free >= 10 * n_parameters ? n_free - n_parameters : n_free);
  result.p_value = chi2_survival(result.chi2, result.ndf);
  return result;
}

std::vector<ResidualBin> residual_bins(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  const std::size_t n = likelihood.data().size();
  const std::size_t n_bins = std::clamp<std::size_t>(n / 12, 1, 24);
  const LawLikelihood::LocationScores of = likelihood.location_scores(theta);
  const ScatterModel scatter = likelihood.scatter_model(theta);
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
      const double v_mps = likelihood.data().v_mps[k], tau = hypot(likelihood.data().tau[k], scatter.normal(v_mps));
      // root mean square distance turned into a mean one is exact for tau = 0 and within 6 % for tau >> b
      expected += hypot(scatter.mean_distance(v_mps), tau * std::sqrt(2.0 / std::numbers::pi));
      score += of.score[k];
    }
    bin.median_residual = upper_median({of.residual.begin() + static_cast<std::ptrdiff_t>(begin),
                                        of.residual.begin() + static_cast<std::ptrdiff_t>(end)});
    bin.pull = score / std::sqrt(static_cast<double>(bin.n) * likelihood.information_of(theta, middle)(0, 0));
    bin.scatter_ratio = distance / expected;
    bins.push_back(bin);
  }
  return bins;
}

namespace {

/// Speeds and timing errors of every n-th sample; timing errors widened as the fit of so few samples would.
LawData thinned_and_widened(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  constexpr std::size_t kEnough = 4000;
  const LawData& all = likelihood.data();
  const std::size_t stride = std::max<std::size_t>(1, all.size() / kEnough);
  LawData data;
  for (std::size_t k = stride / 2; k < all.size(); k += stride) {
    data.v_mps.push_back(all.v_mps[k]);
    data.tau.push_back(all.tau[k]);
    if (!likelihood.scatter().by_place) continue;
    data.log_below.push_back(all.log_below[k]);
    data.log_above.push_back(all.log_above[k]);
  }
  data.eps.resize(data.size());
  if (stride > 1)
    widen(data, likelihood.scatter_model(theta),
          std::sqrt(static_cast<double>(likelihood.model().n_parameters()) / static_cast<double>(data.size())));
  return data;
}

double draw_scatter(double below, double above, double normal_ratio, Random& random) {
  const double exponential =
      random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
  return exponential + (normal_ratio > 0.0 ? normal_ratio * std::sqrt(below * above) * random.normal() : 0.0);
}

}  // namespace

double anderson_darling(std::vector<double> u) {
  std::sort(u.begin(), u.end());
  const std::size_t n = u.size();
  double sum = 0.0;
  std::vector<double> low(n), high(n);
  for (std::size_t i = 0; i < n; ++i) {
    low[i] = std::clamp(u[i], 1e-300, 1.0);
    high[i] = std::clamp(1.0 - u[n - 1 - i], 1e-16, 1.0);
  }
  log_each(low);
  log_each(high);
  for (std::size_t i = 0; i < n; ++i) sum += (2.0 * static_cast<double>(i) + 1.0) * (low[i] + high[i]);
  return -static_cast<double>(n) - sum / static_cast<double>(n);
}

AndersonDarling anderson_darling_test(const LawLikelihood& likelihood, const Maximum& maximum, std::size_t n_replicates,
                                      std::uint64_t seed) {
  AndersonDarling result;
  result.a2 = anderson_darling(likelihood.probabilities_below(maximum.x));
  const LawData design = thinned_and_widened(likelihood, maximum.x);
  const LawLikelihood thin(design, likelihood.model(), likelihood.scatter());
  const Eigen::MatrixXd information = thin.information(maximum.x);
  const double normal_ratio = likelihood.scatter_model(maximum.x).normal_ratio;
  std::vector<std::pair<double, double>> sides;
  for (std::size_t k = 0; k < design.size(); ++k) sides.push_back(thin.sides_of(maximum.x, k));
  const Eigen::VectorXd eps = thin.model().eps(design.v_mps, maximum.x.head(thin.model().n_parameters()));
  std::vector<double> a2(n_replicates, 0.0);
  parallel_for(n_replicates, 0, [&](std::size_t i) {
    Random random(seed, RandomStream::bootstrap, i);
    LawData data = design;
    for (std::size_t k = 0; k < data.size(); ++k)
      data.eps[k] = eps[static_cast<Eigen::Index>(k)] +
                    draw_scatter(sides[k].first, sides[k].second, normal_ratio, random) + data.tau[k] * random.normal();
    const LawLikelihood drawn(data, likelihood.model(), likelihood.scatter());
    a2[i] = anderson_darling(drawn.probabilities_below(maximise(std::cref(drawn), maximum.x, information, 0.02).x));
  });
  result.n_replicates = n_replicates;
  const auto n_larger = std::count_if(a2.begin(), a2.end(), [&](double x) { return x >= result.a2; });
  result.p_value = (1.0 + static_cast<double>(n_larger)) / (1.0 + static_cast<double>(n_replicates));
  return result;
}

}  // namespace bouncelab::fit
