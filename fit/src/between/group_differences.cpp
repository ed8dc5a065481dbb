// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

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
    std::vector<double> v;
    for (const RestitutionSample& s : samples) v.push_back(s.v_mps);
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

/// Weighted sums of one unit's residuals.
struct UnitSums {
  double weight = 0.0, residuals = 0.0;
};

/// A group's law and the residuals of its units.
struct Fitted {
  LawFit fit;
  Eigen::MatrixXd covariance;  ///< of the nodes
  std::vector<UnitSums> units;
  std::vector<double> v_mps, weights;  ///< of its samples
};

Eigen::MatrixXd node_covariance(const LawFit& fit) {
  const auto n = static_cast<Eigen::Index>(fit.nodes.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      covariance(i, j) = fit.node_correlation[a][b] * *fit.nodes[a].eps.se * *fit.nodes[b].eps.se;
    }
  return covariance;
}

Fitted fitted(const RestitutionSamples& samples, const LawFitConfig& config, GroupUnit unit) {
  RestitutionSamples one_drop = samples;  // so that the errors are those of independent samples
  for (RestitutionSample& s : one_drop) s.drop = 0;
  for (RestitutionSample& s : one_drop) s.recording.clear();
  Fitted result{fit_law(one_drop, config), {}, {}, {}, {}};
  const LawFit& fit = result.fit;
  const auto known = [](const NodeEstimate& node) { return node.eps.se && *node.eps.se > 0.0; };
  if (!fit.law || !fit.scatter || fit.nodes.empty() || !std::all_of(fit.nodes.begin(), fit.nodes.end(), known))
    return result;
  result.covariance = node_covariance(fit);
  std::map<std::pair<std::string, std::int64_t>, UnitSums> units;
  const std::vector<double> residuals = residuals_from(*fit.law, samples);
  const std::set<std::size_t> outliers(fit.outliers.begin(), fit.outliers.end());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (outliers.contains(k)) continue;
    const RestitutionSample& s = samples[k];
    UnitSums& sums = units[{s.recording, unit == GroupUnit::drops ? s.drop : 0}];
    const double weight = 1.0 / (fit.scatter->variance(s.v_mps) + square(s.sigma_eps.value_or(0.0)));
    result.v_mps.push_back(s.v_mps);
    result.weights.push_back(weight);
    sums.weight += weight;
    sums.residuals += weight * residuals[k];
  }
  for (const auto& [name, sums] : units) result.units.push_back(sums);
  return result;
}

/// Mean residual of a group, and the inverse of its variance but for Within::q.
struct GroupMean {
  double value = 0.0, weight = 0.0;
};

/// Units weighted by what is known of each: its samples, and how units differ.
GroupMean mean_of(const Fitted& group, double deviation) {
  GroupMean mean;
  for (const UnitSums& u : group.units) {
    const double weight = 1.0 / (square(deviation) + 1.0 / u.weight);
    mean.value += weight * u.residuals / u.weight;
    mean.weight += weight;
  }
  mean.value /= mean.weight;
  return mean;
}

/// Of the units about the means of their groups.
double sum_of_squares(const std::vector<Fitted>& groups, double deviation) {
  double squares = 0.0;
  for (const Fitted& group : groups) {
    const double mean = mean_of(group, deviation).value;
    for (const UnitSums& u : group.units)
      squares += square(u.residuals / u.weight - mean) / (square(deviation) + 1.0 / u.weight);
  }
  return squares;
}

/// How units of one group differ.
struct Within {
  double ndf = 0.0, deviation = 0.0;
  double q = 0.0;  ///< mean square of the units about their groups: 1 where the weights say all
};

Within within(const std::vector<Fitted>& groups) {
  Within result;
  double weights = 0.0;
  for (const Fitted& group : groups) {
    double sum = 0.0, squares = 0.0;
    for (const UnitSums& u : group.units) sum += u.weight, squares += square(u.weight);
    weights += sum - squares / sum;
    result.ndf += static_cast<double>(group.units.size()) - 1.0;
  }
  if (!(result.ndf > 0.0)) return result;
  result.deviation = std::sqrt(std::max(0.0, sum_of_squares(groups, 0.0) - result.ndf) / weights);
  result.q = sum_of_squares(groups, result.deviation) / result.ndf;
  return result;
}

/// What a constant added to eps adds to each constant of the law.
Eigen::VectorXd of_a_constant(const LawFit& fit, const std::vector<double>& v_mps) {
  if (fit.kind == LawKind::constant) return Eigen::VectorXd::Ones(1);
  const LawModel model = make_law_model(fit.kind, LawFitConfig{}.orders, v_mps);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(model.n_parameters());
  return product(model.reported_jacobian(ones), ones);
}

/// Weighted mean of what the second law has more than the first, over the speeds of one group.
double mean_change(const Fitted& over, const RestitutionLaw& first, const RestitutionLaw& second) {
  const std::vector<double> a = restitutions(first, over.v_mps), b = restitutions(second, over.v_mps);
  double sum = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    sum += over.weights[k] * (b[k] - a[k]);
    weights += over.weights[k];
  }
  return sum / weights;
}

class Difference {
 public:
  Difference(const Fitted& first, const Fitted& second, const Within& within, std::size_t n_pairs)
      : first_(first), second_(second), ndf_(within.ndf), n_pairs_(static_cast<double>(n_pairs)) {
    const double n_free = ndf_ > 0.0 ? ndf_ : static_cast<double>(first.fit.n + second.fit.n) - 2.0 * n_curve();
    reach68_ = student_t_quantile(0.8413447460685429, n_free);
    reach95_ = student_t_quantile(0.975, n_free);
    reach80_ = reach95_ + student_t_quantile(0.8, n_free);
    const Eigen::MatrixXd covariance = first.covariance + second.covariance;
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(covariance.rows());
    const Eigen::VectorXd weighted = cholesky(covariance).value().solve(ones);
    const double weight = weighted.sum();
    // of the groups' means about the mean of both laws, which is what the analysis of variance is of
    const RestitutionLaw &a = *first.fit.law, &b = *second.fit.law;
    const GroupMean mean_a = mean_of(first, within.deviation), mean_b = mean_of(second, within.deviation);
    offset_ = mean_b.value - mean_a.value + 0.5 * (mean_change(first, a, b) + mean_change(second, a, b));
    variance_ = std::max(1.0 / weight, within.q * (1.0 / mean_a.weight + 1.0 / mean_b.weight));
    more_ = variance_ - 1.0 / weight;
  }

  GroupDifference row(const std::string& reference, const std::string& group, const Eigen::VectorXd& shift) const {
    GroupDifference row{reference, group, estimate(offset_, variance_), reach80_ * std::sqrt(variance_), {}, {}, {}};
    if (ndf_ > 0.0)
      row.p_value = std::min(1.0, 2.0 * n_pairs_ * student_t_below(-std::abs(offset_) / std::sqrt(variance_), ndf_));
    for (std::size_t i = 0; i < first_.fit.nodes.size(); ++i)
      row.nodes.push_back({first_.fit.nodes[i].v_mps, less(second_.fit.nodes[i].eps, first_.fit.nodes[i].eps, 1.0)});
    for (std::size_t i = 0; i < first_.fit.parameters.size() && i < second_.fit.parameters.size(); ++i)
      row.parameters.push_back(
          {first_.fit.parameters[i].name, less(second_.fit.parameters[i].estimate, first_.fit.parameters[i].estimate,
                                               shift[static_cast<Eigen::Index>(i)])});
    return row;
  }

 private:
  double n_curve() const { return static_cast<double>(first_.fit.nodes.size()); }
  Estimate estimate(double value, double variance) const {
    return normal_estimate(value, std::sqrt(variance), reach68_, reach95_);
  }
  /// @param shift  of it by a constant of 1 in eps
  Estimate less(const Estimate& a, const Estimate& b, double shift) const {
    return estimate(a.value - b.value, square(a.se.value_or(0.0)) + square(b.se.value_or(0.0)) + more_ * square(shift));
  }

  const Fitted &first_, &second_;
  double ndf_, n_pairs_, reach68_ = 0.0, reach95_ = 0.0, reach80_ = 0.0;
  double offset_ = 0.0, variance_ = 0.0, more_ = 0.0;  ///< variance beyond that of independent samples
};

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
  for (const auto& [name, samples] : groups)
    if (samples.empty()) {
      result.why = why_not(groups, {});
      return result;
    }
  const std::pair<double, double> shared = shared_speeds(groups);
  result.why = why_not(groups, shared);
  if (result.why) return result;
  const LawFitConfig config = config_of(groups, shared);
  std::vector<Fitted> all;
  std::vector<double> v_mps;
  for (const auto& [name, samples] : groups) {
    RestitutionSamples part = samples;  // of one eps only the speeds that all have: else its change would count
    if (config.kind == LawKind::constant && shared.second >= kOneSpeed * shared.first)
      std::erase_if(part,
                    [&](const RestitutionSample& s) { return s.v_mps < shared.first || s.v_mps > shared.second; });
    if (part.size() < kFewestOfAGroup) {
      result.why = Note{NoteKind::group_few_at_common,
                        {static_cast<double>(part.size()), shared.first, shared.second},
                        printable(name)};
      return result;
    }
    all.push_back(fitted(part, config, result.unit));
    const Fitted& group = all.back();
    if (group.units.empty() || !cholesky(group.covariance)) {
      result.why = Note{NoteKind::group_without_law, {}, printable(name)};
      return result;
    }
    result.groups.push_back({name, group.fit.n, group.units.size(), group.fit.nodes, group.fit.parameters});
    for (const RestitutionSample& s : part) v_mps.push_back(s.v_mps);
  }
  const Within differing = within(all);
  result.ndf = differing.ndf;
  if (differing.ndf > 0.0) result.deviation = differing.deviation;
  const Eigen::VectorXd shift = of_a_constant(all.front().fit, v_mps);
  const std::size_t n_pairs = all.size() * (all.size() - 1) / 2;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = i + 1; j < all.size(); ++j)
      result.rows.push_back(
          Difference(all[i], all[j], differing, n_pairs).row(groups[i].first, groups[j].first, shift));
  return result;
}

}  // namespace bouncelab::fit
