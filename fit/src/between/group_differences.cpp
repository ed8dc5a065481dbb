// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "between/agreement.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "law/law_model.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

using Group = std::pair<std::string, RestitutionSamples>;

constexpr std::size_t kFewestOfACurve = 30;  // samples of each group; of fewer one eps at the speeds that they share
constexpr std::size_t kFewestOfAGroup = 3;

/// Speeds from the twentieth to the last twentieth, which all groups share.
std::pair<double, double> shared_speeds(const std::vector<Group>& groups) {
  std::pair<double, double> shared{0.0, HUGE_VAL};
  for (const auto& [name, samples] : groups) {
    std::vector<double> v = speeds_of(samples);
    std::sort(v.begin(), v.end());
    shared = {std::max(shared.first, v[v.size() / 20]), std::min(shared.second, v[v.size() - 1 - v.size() / 20])};
  }
  return shared;
}

LawFitConfig config_of(const std::vector<Group>& groups, const std::pair<double, double>& shared) {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  std::size_t least = groups.front().second.size();
  for (const auto& [name, samples] : groups) least = std::min(least, samples.size());
  const bool curve = least >= kFewestOfACurve && shared.second >= kOneSpeed * shared.first;
  config.n_scatter_terms = curve ? 2 : 1;
  if (curve)
    config.node_speeds_mps = spread_speeds(std::vector{shared.first, shared.second}, 3);
  else
    config.kind = LawKind::constant, config.node_speeds_mps = {std::sqrt(shared.first * shared.second)};
  return config;
}

/// Its errors are those of independent samples.
LawFit law_of(RestitutionSamples samples, const LawFitConfig& config) {
  for (RestitutionSample& s : samples) s.drop = 0, s.recording.clear();
  return fit_law(samples, config);
}

bool has_errors(const LawFit& fit) {
  const auto known = [](const NodeEstimate& node) { return node.eps.se && *node.eps.se > 0.0; };
  return fit.law && fit.scatter && !fit.nodes.empty() && std::all_of(fit.nodes.begin(), fit.nodes.end(), known);
}

/// What a constant added to eps adds to each constant of the law.
Eigen::VectorXd of_a_constant(const LawFit& fit, const std::vector<double>& v_mps) {
  if (fit.kind == LawKind::constant) return Eigen::VectorXd::Ones(1);
  const LawModel model = make_law_model(fit.kind, LawFitConfig{}.orders, v_mps);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(model.n_parameters());
  return product(model.reported_jacobian(ones), ones);
}

/// Variance of the difference of two groups' means if samples are independent: the inverse of what a difference of 1
/// leaves where both have one mean.
double variance_if_independent(const UnitSamples& samples, std::size_t a, std::size_t b) {
  UnitSamples differing = samples;
  std::vector<std::size_t> merged;
  for (std::size_t k = 0; k < samples.group.size(); ++k) {
    const std::size_t group = samples.group[k];
    differing.residual[k] = group == b ? 1.0 : 0.0;
    merged.push_back(group == b ? a : group - (group > b ? 1 : 0));
  }
  return 1.0 / unit_means(differing, merged, samples.n_groups - 1).squares;
}

/// How much more, or fewer units, than independent samples say.
struct Within {
  double ndf = 0.0;
  double mean_square = 1.0;         ///< of the units' means about those of their groups, never below 1
  std::optional<double> deviation;  ///< standard deviation of eps between units, beyond the scatter
};

Within within(const UnitSamples& samples, const UnitMeans& groups) {
  const UnitMeans units = unit_means(samples, samples.unit, samples.n_units);
  Within result;
  result.ndf = static_cast<double>(samples.n_units - samples.n_groups);
  if (!(result.ndf > 0.0)) return result;
  const double squares = std::max(0.0, groups.squares - units.squares);
  result.mean_square = std::max(1.0, squares / result.ndf);
  std::vector<std::size_t> group_of(samples.n_units);
  for (std::size_t k = 0; k < samples.unit.size(); ++k) group_of[samples.unit[k]] = samples.group[k];
  double weights = 0.0;
  for (std::size_t u = 0; u < samples.n_units; ++u)
    weights += units.weight[u] * (1.0 - units.weight[u] / groups.weight[group_of[u]]);
  result.deviation = std::sqrt(std::max(0.0, squares - result.ndf) / weights);
  return result;
}

/// @param offset    second less first
/// @param variance  of it if samples are independent
/// @param shift     of each constant by a constant of 1 in eps
GroupDifference difference(const GroupLaw& first, const GroupLaw& second, double offset, double variance,
                           const Within& within, double n_pairs, const Eigen::VectorXd& shift) {
  const double ndf = within.ndf > 0.0
                         ? within.ndf
                         : static_cast<double>(first.n + second.n) - 2.0 * static_cast<double>(first.nodes.size());
  const double all = within.mean_square * variance;
  /// @param by_shift  of it by a constant of 1 in eps: what units differ by goes along
  const auto less = [&](const Estimate& a, const Estimate& b, double by_shift) {
    return student_estimate(
        a.value - b.value,
        square(a.se.value_or(0.0)) + square(b.se.value_or(0.0)) + (all - variance) * square(by_shift), ndf);
  };
  GroupDifference row{first.name, second.name, student_estimate(offset, all, ndf), {}, {}, {}, {}};
  row.detectable = (student_t_quantile(0.975, ndf) + student_t_quantile(0.8, ndf)) * std::sqrt(all);
  if (within.ndf > 0.0)
    row.p_value = std::min(1.0, 2.0 * n_pairs * student_t_below(-std::abs(offset) / std::sqrt(all), within.ndf));
  for (std::size_t i = 0; i < first.nodes.size(); ++i)
    row.nodes.push_back({first.nodes[i].v_mps, less(second.nodes[i].eps, first.nodes[i].eps, 1.0)});
  for (std::size_t i = 0; i < first.parameters.size() && i < second.parameters.size(); ++i)
    row.parameters.push_back(
        {first.parameters[i].name,
         less(second.parameters[i].estimate, first.parameters[i].estimate, shift[static_cast<Eigen::Index>(i)])});
  return row;
}

/// @param weight  of the group: the inverse of its mean's variance if samples are independent
GroupRestitution alone(const GroupLaw& group, double weight, const Within& within) {
  const NodeEstimate& node = group.nodes[group.nodes.size() / 2];
  const double ndf = within.ndf > 0.0 ? within.ndf : static_cast<double>(group.n - group.nodes.size());
  const double variance = square(node.eps.se.value_or(0.0)) + (within.mean_square - 1.0) / weight;
  GroupRestitution result{group.name, group.n_units, node.v_mps, student_estimate(node.eps.value, variance, ndf), {}};
  const double of_one = static_cast<double>(group.n_units) / weight;  // variance of a unit's mean by the scatter
  if (within.deviation)
    result.prediction95 = student_estimate(node.eps.value, variance + square(*within.deviation) + of_one, ndf).ci95;
  return result;
}

/// Absent where they can be compared.
std::optional<Note> why_not(const std::vector<Group>& groups, const std::pair<double, double>& shared) {
  for (const auto& [name, samples] : groups)
    if (samples.size() < kFewestOfAGroup)
      return Note{NoteKind::group_too_small,
                  {static_cast<double>(samples.size()), static_cast<double>(kFewestOfAGroup)},
                  printable(name)};
  if (shared.second < shared.first) return Note{NoteKind::no_common_speeds, {shared.second, shared.first}};
  return std::nullopt;
}

}  // namespace

const char* to_string(GroupUnit unit) { return unit == GroupUnit::drops ? "drops" : "recordings"; }

GroupDifferences compare_groups(const std::vector<Group>& groups) {
  GroupDifferences result;
  for (const auto& [name, samples] : groups) {
    std::set<std::string> recordings;
    for (const RestitutionSample& s : samples) recordings.insert(s.recording);
    if (recordings.size() > 1) result.unit = GroupUnit::recordings;
  }
  std::pair<double, double> shared{0.0, HUGE_VAL};
  result.why = why_not(groups, shared);
  if (!result.why) result.why = why_not(groups, shared = shared_speeds(groups));
  if (result.why) return result;
  const LawFitConfig config = config_of(groups, shared);
  std::vector<RestitutionSamples> parts;
  std::vector<LawFit> fits;
  for (const auto& [name, samples] : groups) {
    parts.push_back(samples);  // of one eps only the speeds that all have: else its change would count
    RestitutionSamples& part = parts.back();
    if (config.kind == LawKind::constant && shared.second >= kOneSpeed * shared.first)
      std::erase_if(part,
                    [&](const RestitutionSample& s) { return s.v_mps < shared.first || s.v_mps > shared.second; });
    if (part.size() < kFewestOfAGroup) {
      result.why = Note{NoteKind::group_few_at_common,
                        {static_cast<double>(part.size()), shared.first, shared.second},
                        printable(name)};
      return result;
    }
    fits.push_back(law_of(part, config));
    if (!has_errors(fits.back())) {
      result.why = Note{NoteKind::group_without_law, {}, printable(name)};
      return result;
    }
    result.groups.push_back({name, fits.back().n, 0, fits.back().nodes, fits.back().parameters});
  }
  std::vector<UnitGroup> of_table;
  std::vector<double> v_mps;
  for (std::size_t g = 0; g < parts.size(); ++g) {
    of_table.push_back({&parts[g], &fits[g].outliers, &*fits[g].scatter});
    for (const RestitutionSample& s : parts[g]) v_mps.push_back(s.v_mps);
  }
  const UnitSamples samples = unit_samples(of_table, fits.front(), config.orders, result.unit == GroupUnit::recordings);
  std::set<std::pair<std::size_t, std::size_t>> units;
  for (std::size_t k = 0; k < samples.unit.size(); ++k)
    if (units.emplace(samples.group[k], samples.unit[k]).second) ++result.groups[samples.group[k]].n_units;
  const UnitMeans means = unit_means(samples, samples.group, samples.n_groups);
  const Within differing = within(samples, means);
  result.ndf = differing.ndf;
  result.deviation = differing.deviation;
  for (std::size_t g = 0; g < parts.size(); ++g)
    result.alone.push_back(alone(result.groups[g], means.weight[g], differing));
  const Eigen::VectorXd shift = of_a_constant(fits.front(), v_mps);
  const std::size_t n_pairs = parts.size() * (parts.size() - 1) / 2;
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = i + 1; j < parts.size(); ++j)
      result.rows.push_back(difference(result.groups[i], result.groups[j], means.mean[j] - means.mean[i],
                                       variance_if_independent(samples, i, j), differing, static_cast<double>(n_pairs),
                                       shift));
  return result;
}

}  // namespace bouncelab::fit
