// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "between/design.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "bouncelab/fit/usable_samples.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kDropsOfACovariance = 30;
constexpr std::size_t kWidthKnown = 30;  // samples; below, fit_law takes one term of the scatter without a choice

LawFitConfig config_of(const std::vector<double>& sorted_v_mps) {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  config.node_speeds_mps = spread_speeds(sorted_v_mps, 3);
  if (sorted_v_mps.size() >= kWidthKnown) config.n_scatter_terms = 2;
  // the twentieths at either end may hold stray speeds, as for fit_law
  const std::size_t n = sorted_v_mps.size();
  if (sorted_v_mps[n - 1 - n / 20] < kOneSpeed * sorted_v_mps[n / 20]) {
    config.kind = LawKind::constant;
    config.node_speeds_mps = {sorted_v_mps[n / 2]};
  }
  return config;
}

void take_nodes(RecordingSummary& summary, const LawFit& fit) {
  summary.n_nodes = fit.nodes.size();
  for (std::size_t i = 0; i < summary.n_nodes; ++i) {
    summary.v_mps[i] = fit.nodes[i].v_mps;
    summary.eps[i] = fit.nodes[i].eps.value;
    for (std::size_t j = 0; j < summary.n_nodes; ++j)
      summary.covariance[i][j] = fit.node_correlation[i][j] * *fit.nodes[i].eps.se * *fit.nodes[j].eps.se;
  }
}

/// Can what is known of the values be weighted by its inverse?
bool has_inverse(const RecordingSummary& summary) {
  const auto n = static_cast<Eigen::Index>(summary.n_nodes);
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      covariance(i, j) = summary.covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return cholesky(covariance).has_value();
}

}  // namespace

RecordingSummary summarize_recording(const RestitutionSamples& samples) {
  RecordingSummary summary;
  summary.recording = samples.front().recording;
  LeftOut left_out;
  RestitutionSamples used = *usable_samples(samples, left_out);
  summary.n_left_out = samples.size() - used.size();
  summary.n = used.size();
  std::set<std::int64_t> drops;
  std::vector<double> v_mps;
  for (const RestitutionSample& s : used) {
    drops.insert(s.drop);
    v_mps.push_back(s.v_mps);
  }
  summary.n_drops = drops.size();
  if (used.size() < kFewestOfASummary) {
    summary.message =
        std::to_string(used.size()) + " usable samples: at least " + std::to_string(kFewestOfASummary) + " are needed";
    return summary;
  }
  if (drops.size() < kDropsOfACovariance)
    for (RestitutionSample& s : used) s.drop = 0;
  std::sort(v_mps.begin(), v_mps.end());
  const LawFit fit = fit_law(used, config_of(v_mps));
  summary.n = fit.n;
  summary.n_outliers = fit.outliers.size();
  summary.status = fit.status == FitStatus::not_identifiable ? FitStatus::ok : fit.status;  // the curve is known
  summary.message = summary.status == FitStatus::ok ? "" : fit.message;
  if (summary.status != FitStatus::ok) return summary;
  const auto known = [](const NodeEstimate& node) { return node.eps.se && *node.eps.se > 0.0; };
  if (fit.nodes.empty() || !std::all_of(fit.nodes.begin(), fit.nodes.end(), known)) {
    summary.status = FitStatus::not_identifiable;
    summary.message = fit.message.empty() ? "its own law has no standard error" : fit.message;
    return summary;
  }
  take_nodes(summary, fit);
  if (!has_inverse(summary)) {
    summary.status = FitStatus::not_identifiable;
    summary.message = "the errors of its own law cannot be told apart";
  }
  if (fit.scatter) {
    const double v = v_mps[v_mps.size() / 2], below = fit.scatter->below(v), above = fit.scatter->above(v);
    summary.scatter = (below * below + above * above) / (below + above);
  }
  return summary;
}

}  // namespace bouncelab::fit
