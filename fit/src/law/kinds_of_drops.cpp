// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/fit/recordings.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestSamples = 3;    // of a drop whose median says something
constexpr std::ptrdiff_t kFewestOfKind = 2;  // of each kind: one alone may have met something
constexpr double kFarApart = 3.0;            // gap over width of a group, and over scatter
// gap over 1 - eps: over a factor 10 of speed between the kinds the curvature of v^(1/5) in ln v leaves a fourth of it
constexpr double kBeyondCurvature = 0.1;

struct Drop {
  std::vector<double> ln_v, eps;
  double at_one_speed = 0.0;  ///< median of eps - slope ln v
};

std::vector<Drop> drops_of(const RestitutionSamples& samples) {
  std::map<std::pair<std::string, std::int64_t>, Drop> by_name;
  for (const RestitutionSample& s : samples) {
    Drop& drop = by_name[{s.recording, s.drop}];
    drop.ln_v.push_back(log(s.v_mps));
    drop.eps.push_back(s.eps);
  }
  std::vector<Drop> drops;
  for (auto& [name, drop] : by_name)
    if (drop.eps.size() >= kFewestSamples) drops.push_back(std::move(drop));
  return drops;
}

/// d eps / d ln v within drops: the median of what their faster and slower halves say. Of all samples together it would
/// hold the difference between balls that were dropped from different heights.
double slope_within(const std::vector<Drop>& drops) {
  std::vector<double> slopes;
  for (const Drop& drop : drops) {
    std::vector<std::size_t> order(drop.eps.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return drop.ln_v[a] < drop.ln_v[b]; });
    std::array<std::vector<double>, 2> ln_v, eps;  // of the slower half, of the faster one
    for (std::size_t k = 0; k < order.size(); ++k) {
      const bool is_faster = k >= order.size() / 2;
      ln_v[is_faster].push_back(drop.ln_v[order[k]]);
      eps[is_faster].push_back(drop.eps[order[k]]);
    }
    const double span = median(ln_v[1]) - median(ln_v[0]);
    if (span > 0.0) slopes.push_back((median(eps[1]) - median(eps[0])) / span);
  }
  return slopes.empty() ? 0.0 : median(std::move(slopes));
}

}  // namespace

std::optional<KindsOfDrops> two_kinds_of_drops(const RestitutionSamples& samples) {
  std::vector<Drop> drops = drops_of(samples);
  const double slope = slope_within(drops);
  std::vector<double> deviations;
  for (Drop& drop : drops) {
    std::vector<double> eps = drop.eps;
    for (std::size_t k = 0; k < eps.size(); ++k) eps[k] -= slope * drop.ln_v[k];
    drop.at_one_speed = median(eps);
    for (const double e : eps) deviations.push_back(std::abs(e - drop.at_one_speed));
  }
  std::sort(drops.begin(), drops.end(), [](const Drop& a, const Drop& b) { return a.at_one_speed < b.at_one_speed; });
  const auto n = std::ssize(drops);
  std::ptrdiff_t below = 0;  // how many of them are in the lower group
  double gap = 0.0;
  for (std::ptrdiff_t k = kFewestOfKind; k + kFewestOfKind <= n; ++k)
    if (const double here = drops[k].at_one_speed - drops[k - 1].at_one_speed; here > gap) gap = here, below = k;
  if (below == 0) return {};
  const double widest = std::max(drops[below - 1].at_one_speed - drops.front().at_one_speed,
                                 drops.back().at_one_speed - drops[below].at_one_speed);
  constexpr double kSdOverMad = 1.4826;  // of a normal
  if (gap < kFarApart * std::max(widest, kSdOverMad * median(std::move(deviations)))) return {};
  if (gap < kBeyondCurvature * (1.0 - drops.front().at_one_speed)) return {};
  std::vector<double> lower, upper;
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    std::vector<double>& kind = k < below ? lower : upper;
    kind.insert(kind.end(), drops[k].eps.begin(), drops[k].eps.end());
  }
  return KindsOfDrops{static_cast<std::size_t>(below), static_cast<std::size_t>(n - below), median(std::move(lower)),
                      median(std::move(upper))};
}

}  // namespace bouncelab::fit
