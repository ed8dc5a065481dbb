// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/recordings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "between/agreement.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestOfRecording = 3;
constexpr std::size_t kManyRecordings = 100;  // recordings: rows in a third of the time from there on

std::vector<RestitutionSamples> by_recording(const RestitutionSamples& samples) {
  std::map<std::string, std::size_t> numbers;
  std::vector<RestitutionSamples> groups;
  for (const RestitutionSample& s : samples) {
    const std::size_t number = numbers.try_emplace(s.recording, groups.size()).first->second;
    if (number == groups.size()) groups.emplace_back();
    groups[number].push_back(s);
  }
  return groups;
}

/// The table of units: the samples that recordings keep, about the curve of all.
UnitSamples units_of(const std::vector<RestitutionSamples>& recordings, const std::vector<RecordingFit>& rows,
                     const LawFitConfig& config, const LawFit& pooled) {
  RestitutionSamples kept;
  UnitSamples units;
  std::size_t n_drops = 0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (recordings[r].size() < kFewestOfRecording) continue;
    std::map<std::int64_t, std::size_t> drops;
    for (std::size_t k = 0; k < recordings[r].size(); ++k) {
      if (std::binary_search(rows[r].outliers.begin(), rows[r].outliers.end(), k)) continue;
      const RestitutionSample& s = recordings[r][k];
      kept.push_back(s);
      units.group.push_back(units.n_groups);
      units.drop.push_back(drops.try_emplace(s.drop, n_drops + drops.size()).first->second);
    }
    n_drops += drops.size();
    ++units.n_groups;
  }
  units.n_drops = n_drops;
  if (units.n_groups < 2) return units;
  const std::vector<int> orders(
      config.orders.begin(),
      config.orders.begin() + static_cast<std::ptrdiff_t>(std::min(config.orders.size(), pooled.parameters.size())));
  std::vector<double> v_mps;
  for (const RestitutionSample& s : kept) {
    v_mps.push_back(s.v_mps);
    units.weight.push_back(1.0 / (pooled.scatter->variance(s.v_mps) + square(s.sigma_eps.value_or(0.0))));
  }
  units.residual = residuals_from(*pooled.law, kept);
  const LawModel model = make_law_model(pooled.kind, orders, v_mps);
  const double gamma = pooled.kind == LawKind::viscoelastic ? pooled.parameters.front().estimate.value : 1.0;
  units.curve = model.jacobian(v_mps, Eigen::VectorXd::Constant(model.n_parameters(), log(gamma)));
  return units;
}

RecordingFit row_of(const RestitutionSamples& samples, LawFitConfig config, const LawFit& pooled, bool is_one_of_many) {
  RecordingFit row;
  row.recording = samples.front().recording;
  std::set<std::int64_t> drops;
  std::vector<double> v;
  for (const RestitutionSample& s : samples) {
    drops.insert(s.drop);
    v.push_back(s.v_mps);
  }
  std::sort(v.begin(), v.end());
  row.n_drops = drops.size();
  row.v_lo_mps = v.front();
  row.v_hi_mps = v.back();
  config.node_speeds_mps.clear();
  for (const NodeEstimate& node : pooled.nodes)
    if (node.v_mps >= row.v_lo_mps && node.v_mps <= row.v_hi_mps) config.node_speeds_mps.push_back(node.v_mps);
  if (config.node_speeds_mps.empty()) config.node_speeds_mps = {v[v.size() / 2]};
  config.n_goodness = config.n_bootstrap = 0;
  config.compare_laws = false;
  if (is_one_of_many) {
    constexpr std::size_t kWidthKnown = 30;  // below, fit_law takes one term without a choice
    config.intervals = IntervalMethod::covariance;
    if (config.n_scatter_terms == 0 && samples.size() >= kWidthKnown) config.n_scatter_terms = 2;
  }
  LawFit fit = fit_law(samples, config);
  row.n = fit.n;
  row.n_outliers = fit.outliers.size();
  row.outliers = std::move(fit.outliers);
  row.status = fit.status;
  row.why = fit.why;
  row.kind = fit.kind;
  row.nodes = std::move(fit.nodes);
  row.parameters = std::move(fit.parameters);
  return row;
}

/// Offsets about their mean over all samples.
void add_offsets(const Agreement& agreement, std::vector<RecordingFit>& rows) {
  auto next = agreement.offsets.begin();
  for (RecordingFit& row : rows)
    if (row.n + row.n_outliers >= kFewestOfRecording) row.offset = *next++;
}

}  // namespace

bool disagree(const Recordings& recordings) { return recordings.test && recordings.test->p_value < kDoubt; }

const char* to_string(WithinUnit unit) { return unit == WithinUnit::drops ? "drops" : "samples"; }

Recordings compare_recordings(const RestitutionSamples& samples, const LawFitConfig& config, const LawFit& pooled) {
  const std::vector<RestitutionSamples> recordings = by_recording(samples);
  if (recordings.size() < 2) return {};
  Recordings result;
  result.rows.resize(recordings.size());
  with_threads(0, [&] {
    parallel_for(recordings.size(), 0, [&](std::size_t k) {
      result.rows[k] = row_of(recordings[k], config, pooled, recordings.size() > kManyRecordings);
    });
    if (!pooled.law || !pooled.scatter) return;
    if (const auto found = agreement(units_of(recordings, result.rows, config, pooled))) {
      result.test = found->test;
      add_offsets(*found, result.rows);
    }
  });
  return result;
}

}  // namespace bouncelab::fit
