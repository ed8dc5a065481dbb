// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/group_differences.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "between/speeds.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "curve/smooth_curve.hpp"
#include "numerics/numerics.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {
namespace {

using Group = std::pair<std::string, RestitutionSamples>;

constexpr std::size_t kFewestOfAGroup = 3;

double half_width(const Estimate& e) { return 0.5 * (e.ci95->hi - e.ci95->lo); }

/// Degrees of freedom of Student's t, also where units do not tell.
double n_free(double ndf) { return ndf > 0.0 ? ndf : 1e9; }

/// Second less first, which are independent: half widths of intervals in quadrature (Zou & Donner, Stat. Med. 27, 1693
/// (2008), doi:10.1002/sim.3095).
Estimate less(const Estimate& second, const Estimate& first, double ndf) {
  const double se = hypot(half_width(first), half_width(second)) / student_t_quantile(0.975, n_free(ndf));
  return student_estimate(second.value - first.value, square(se), n_free(ndf));
}

/// @param n_pairs  that are judged together
GroupDifference row_of(const GroupRestitution& first, const GroupRestitution& second, const DifferenceOfTwo& difference,
                       double n_pairs) {
  const auto& [eps, ndf] = difference;
  GroupDifference row{first.name, second.name, first.v_mps, eps, ndf, 0.0, {}, {}};
  row.detectable = (student_t_quantile(0.975, n_free(ndf)) + student_t_quantile(0.8, n_free(ndf))) * *eps.se;
  if (ndf > 0.0) row.p_value = std::min(1.0, 2.0 * n_pairs * student_t_below(-std::abs(eps.value) / *eps.se, ndf));
  return row;
}

/// Between which speeds of comparison all groups are; the first above the second where they are nowhere.
std::pair<double, double> shared_speeds(const std::vector<Group>& groups) {
  std::pair<double, double> shared{0.0, HUGE_VAL};
  for (const auto& [name, samples] : groups) {
    const std::vector<double> own = speeds_of_comparison(samples);
    shared = {std::max(shared.first, own.front()), std::min(shared.second, own.back())};
  }
  return shared;
}

/// Samples that are at the plate: nothing of drag and contact time is open.
Curve curve_of(const RestitutionSamples& samples, std::vector<double> speeds) {
  AirAndContact known = air_and_contact_of(samples);
  known.has_drag = known.has_contact = false;
  return SmoothCurve(samples, {known}, std::move(speeds)).curve();
}

const GroupRestitution& named(const GroupDifferences& differences, const std::string& name) {
  return *std::find_if(differences.groups.begin(), differences.groups.end(),
                       [&](const GroupRestitution& group) { return group.name == name; });
}

/// Of the drops of one recording. @param ndf  as GroupDifference has it
GroupRestitution by_drops(const Group& group, const std::vector<double>& speeds, double ndf) {
  const Curve curve = curve_of(group.second, speeds);
  GroupRestitution result{group.first, curve.n_drops, speeds[speeds.size() / 2], {}, {}, {}};
  for (const CurveNode& node : curve.nodes) result.nodes.push_back({node.v_mps, node.eps});
  result.eps = result.nodes[speeds.size() / 2].eps;
  if (!curve.scatter_of_drops || !(ndf > 0.0)) return result;
  const double bounces_a_drop = static_cast<double>(group.second.size()) / static_cast<double>(curve.n_drops);
  const double of_one = hypot(*curve.scatter_of_drops, curve.scatter / std::sqrt(bounces_a_drop));
  const double reach = hypot(half_width(result.eps), student_t_quantile(0.975, ndf) * of_one);
  result.prediction95 = Interval{result.eps.value - reach, result.eps.value + reach};
  return result;
}

}  // namespace

const char* to_string(GroupUnit unit) { return unit == GroupUnit::drops ? "drops" : "recordings"; }

void add_pairs(GroupDifferences& differences,
               const std::function<DifferenceOfTwo(std::size_t first, std::size_t second)>& of) {
  const std::vector<GroupRestitution>& groups = differences.groups;
  const double n_pairs = 0.5 * static_cast<double>(groups.size()) * static_cast<double>(groups.size() - 1);
  const bool are_few = groups.size() <= kMostGroups;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t j = i + 1; j < groups.size(); ++j) {
      GroupDifference row = row_of(groups[i], groups[j], of(i, j), n_pairs);
      differences.differ = differences.differ || row.p_value.value_or(0.0) < 0.05;
      if (are_few) differences.rows.push_back(std::move(row));
    }
}

GroupDifferences compare_groups(const std::vector<Group>& groups) {
  GroupDifferences result;
  std::size_t n_drops = 0;
  for (const auto& [name, samples] : groups) {
    if (samples.size() < kFewestOfAGroup) {
      result.why = Note{NoteKind::group_too_small,
                        {static_cast<double>(samples.size()), static_cast<double>(kFewestOfAGroup)},
                        printable(name)};
      return result;
    }
    std::set<std::int64_t> drops;
    for (const RestitutionSample& s : samples) drops.insert(s.drop);
    n_drops += drops.size();
  }
  const auto [slowest_mps, fastest_mps] = shared_speeds(groups);
  if (slowest_mps > fastest_mps) {
    result.why = Note{NoteKind::no_common_speeds, {fastest_mps, slowest_mps}};
    return result;
  }
  std::vector<double> speeds = speeds_of_comparison(groups.front().second);
  std::erase_if(speeds, [lo = slowest_mps, hi = fastest_mps](double v_mps) { return v_mps < lo || v_mps > hi; });
  const auto ndf = static_cast<double>(n_drops - groups.size());
  for (const Group& group : groups) result.groups.push_back(by_drops(group, speeds, ndf));
  add_pairs(result, [&](std::size_t i, std::size_t j) {
    return DifferenceOfTwo{less(result.groups[j].eps, result.groups[i].eps, ndf), ndf};
  });
  for (GroupDifference& row : result.rows)
    for (std::size_t k = 0; k < speeds.size(); ++k)
      row.nodes.push_back(
          {speeds[k], less(named(result, row.group).nodes[k].eps, named(result, row.reference).nodes[k].eps, ndf)});
  return result;
}

}  // namespace bouncelab::fit
