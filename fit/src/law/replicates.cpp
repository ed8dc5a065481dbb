// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/replicates.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/statistics.hpp"
#include "law/columns.hpp"
#include "law/start_values.hpp"

namespace bouncelab::fit {
namespace {

LogLikelihood function_of(const LawLikelihood& likelihood) {
  return [&](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) { return likelihood(x, gradient); };
}

/// Speeds and timing errors of every n-th sample; timing errors widened as the fit of so few samples would.
LawData thinned_and_widened(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  constexpr std::size_t kEnough = 4000;
  const LawData& all = likelihood.data();
  const std::size_t stride = std::max<std::size_t>(1, all.size() / kEnough);
  LawData data = thinned(all, stride);
  if (stride > 1 && likelihood.scatter().kind != ScatterKind::normal)
    widen(data, likelihood.scatter_model(theta),
          std::sqrt(static_cast<double>(likelihood.model().n_parameters()) / static_cast<double>(data.size())));
  return data;
}

double draw_scatter(ScatterKind kind, double below, double above, double normal_ratio, Random& random) {
  if (kind == ScatterKind::normal) return below * random.normal();
  const double exponential =
      random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
  return exponential + (normal_ratio > 0.0 ? normal_ratio * std::sqrt(below * above) * random.normal() : 0.0);
}

/// Samples of the drops drawn, each as often as drawn, still in order of speed.
LawData resampled(const LawData& data, std::size_t n_drops, Random& random) {
  std::vector<int> times(n_drops, 0);
  for (std::size_t i = 0; i < n_drops; ++i)
    ++times[std::min(static_cast<std::size_t>(random.uniform() * static_cast<double>(n_drops)), n_drops - 1)];
  LawData drawn;
  for (std::size_t k = 0; k < data.size(); ++k) {
    for (int i = 0; i < times[data.drop[k]]; ++i) {
      drawn.v_mps.push_back(data.v_mps[k]);
      drawn.eps.push_back(data.eps[k]);
      drawn.tau.push_back(data.tau[k]);
      drawn.drop.push_back(data.drop[k]);
    }
  }
  return drawn;
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
  LawData design = thinned_and_widened(likelihood, maximum.x);
  design.basis = make_law_basis(likelihood.model(), design.v_mps);
  const LawLikelihood thin(design, likelihood.model(), likelihood.scatter());
  const Eigen::MatrixXd information = thin.information(maximum.x);
  const ScatterModel scatter = likelihood.scatter_model(maximum.x);
  const ScaleColumns b = scales_at(scatter, design.v_mps);
  const ScatterKind kind = likelihood.scatter().kind;
  std::vector<double> a2(n_replicates, 0.0);
  parallel_for(n_replicates, 0, [&](std::size_t i) {
    Random random(seed, RandomStream::bootstrap, i);
    LawData data = design;
    for (std::size_t k = 0; k < data.size(); ++k)
      data.eps[k] = thin.eps_of(maximum.x, k) +
                    draw_scatter(kind, b.below[k], b.above[k], scatter.normal_ratio, random) +
                    data.tau[k] * random.normal();
    const LawLikelihood drawn(data, likelihood.model(), likelihood.scatter());
    a2[i] = anderson_darling(drawn.probabilities_below(maximise(function_of(drawn), maximum.x, information, 0.02).x));
  });
  result.n_replicates = n_replicates;
  const auto n_larger = std::count_if(a2.begin(), a2.end(), [&](double x) { return x >= result.a2; });
  result.p_value = (1.0 + static_cast<double>(n_larger)) / (1.0 + static_cast<double>(n_replicates));
  return result;
}

std::vector<Eigen::VectorXd> bootstrap_by_drop(const LawLikelihood& likelihood, const Maximum& maximum,
                                               std::size_t n_replicates, std::uint64_t seed) {
  constexpr std::size_t kFewestToDraw = 8;
  const LawData& data = likelihood.data();
  const std::size_t n_drops = data.size() == 0 ? 0 : *std::max_element(data.drop.begin(), data.drop.end()) + 1;
  if (n_drops < kFewestToDraw) return {};
  const Eigen::MatrixXd information = likelihood.information(maximum.x);
  std::vector<std::optional<Eigen::VectorXd>> found(n_replicates);  // absent where the search failed
  parallel_for(n_replicates, 0, [&](std::size_t i) {
    // indices beyond those of the goodness of fit
    Random random(seed, RandomStream::bootstrap, (std::uint64_t{1} << 32) + i);
    const LawData drawn = resampled(data, n_drops, random);
    const LawLikelihood again(drawn, likelihood.model(), likelihood.scatter());
    const Maximum there = maximise(function_of(again), maximum.x, information, 0.02);
    if (there.gain_left < 0.01) found[i] = there.x.head(likelihood.model().n_parameters());
  });
  std::vector<Eigen::VectorXd> q;
  for (std::optional<Eigen::VectorXd>& x : found)
    if (x) q.push_back(*std::move(x));
  return q;
}

BootstrapErrors bootstrap_errors(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double mean = 0.0, square = 0.0;
  for (const double x : values) mean += x / n;
  for (const double x : values) square += (x - mean) * (x - mean);
  BootstrapErrors errors;
  errors.se = std::sqrt(square / (n - 1.0));
  errors.ci68 = {quantile(values, 0.15866), quantile(values, 0.84134)};
  errors.ci95 = {quantile(values, 0.025), quantile(values, 0.975)};
  errors.n_replicates = values.size();
  return errors;
}

}  // namespace bouncelab::fit
