// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "between/agreement.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/fit/recordings.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestSamples = 3;    // of a drop whose median says something
constexpr std::ptrdiff_t kFewestOfKind = 2;  // of each kind, but of two drops: one alone may have met something
constexpr double kSdOverMad = 1.4826;        // of a normal
constexpr double kFarApart = 3.0;            // gap over width of a group, and over scatter
// gap over 1 - eps: over a factor 10 of speed between the kinds the curvature of v^(1/5) in ln v leaves a fourth of it
constexpr double kBeyondCurvature = 0.1;

struct Drop {
  std::vector<double> ln_v, eps;
  double ln_v_median = 0.0;
  double at_one_speed = 0.0;  ///< median of eps - slope ln v
};

/// What bounces of a drop scatter, and what is known of the change with speed.
struct Scatter {
  double sd = 0.0;                     ///< of eps, about the median of its drop; or what the timing makes of it
  double slope = 0.0, slope_se = 0.0;  ///< d eps / d ln v within drops
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

/// Sets each drop's `at_one_speed`.
Scatter bring_to_one_speed(std::vector<Drop>& drops) {
  const double slope = slope_within(drops);
  std::vector<double> deviations;
  double leverage = 0.0;
  for (Drop& drop : drops) {
    std::vector<double> eps = drop.eps;
    for (std::size_t k = 0; k < eps.size(); ++k) eps[k] -= slope * drop.ln_v[k];
    drop.at_one_speed = median(eps);
    drop.ln_v_median = median(drop.ln_v);
    for (const double e : eps) deviations.push_back(std::abs(e - drop.at_one_speed));
    for (const double ln_v : drop.ln_v) leverage += square(ln_v - drop.ln_v_median);
  }
  if (deviations.empty()) return {};
  Scatter scatter{kSdOverMad * median(std::move(deviations)), slope, 0.0};
  // medians of halves use the samples half as well as least squares
  if (leverage > 0.0) scatter.slope_se = 2.0 * scatter.sd / std::sqrt(leverage);
  return scatter;
}

/// Standard error of eps by the timing, of most bounces; 0 where it is not known.
double timing_of(const RestitutionSamples& samples) {
  std::vector<double> sigma;
  for (const RestitutionSample& s : samples) sigma.push_back(s.sigma_eps.value_or(0.0));
  return sigma.empty() ? 0.0 : median(std::move(sigma));
}

/// Drops in two groups, the first `below` of them in one, with eps as a straight line in ln v.
UnitSamples units_of(const std::vector<Drop>& drops, std::size_t below) {
  UnitSamples units;
  std::vector<double> ln_v;
  for (std::size_t d = 0; d < drops.size(); ++d)
    for (std::size_t k = 0; k < drops[d].eps.size(); ++k) {
      units.residual.push_back(drops[d].eps[k]);
      ln_v.push_back(drops[d].ln_v[k]);
      units.group.push_back(d < below ? 0 : 1);
      units.drop.push_back(d);
    }
  units.weight.assign(ln_v.size(), 1.0);
  units.curve = Eigen::Map<const Eigen::VectorXd>(ln_v.data(), static_cast<Eigen::Index>(ln_v.size()));
  units.n_groups = 2;
  units.n_drops = drops.size();
  return units;
}

}  // namespace

std::optional<KindsOfDrops> two_kinds_of_drops(const RestitutionSamples& samples) {
  std::vector<Drop> drops = drops_of(samples);
  const Scatter scatter = bring_to_one_speed(drops);
  std::sort(drops.begin(), drops.end(), [](const Drop& a, const Drop& b) { return a.at_one_speed < b.at_one_speed; });
  const auto n = std::ssize(drops);
  std::ptrdiff_t below = 0;  // how many of them are in the lower group
  double gap = 0.0;
  const std::ptrdiff_t fewest = n == 2 ? 1 : kFewestOfKind;
  for (std::ptrdiff_t k = fewest; k + fewest <= n; ++k)
    if (const double here = drops[k].at_one_speed - drops[k - 1].at_one_speed; here > gap) gap = here, below = k;
  if (below == 0) return {};
  const double widest = std::max(drops[below - 1].at_one_speed - drops.front().at_one_speed,
                                 drops.back().at_one_speed - drops[below].at_one_speed);
  const auto ln_v_of = [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    std::vector<double> ln_v;
    for (std::ptrdiff_t k = first; k < last; ++k) ln_v.push_back(drops[k].ln_v_median);
    return median(std::move(ln_v));
  };
  const double by_slope = scatter.slope_se * std::abs(ln_v_of(0, below) - ln_v_of(below, n));
  if (gap < kFarApart * std::max({widest, scatter.sd, timing_of(samples), by_slope})) return {};
  if (gap < kBeyondCurvature * (1.0 - drops.front().at_one_speed)) return {};
  const auto test = agreement(units_of(drops, static_cast<std::size_t>(below)));
  if (!test || test->test.p_value >= kDoubt) return {};
  std::vector<double> lower, upper;
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    std::vector<double>& kind = k < below ? lower : upper;
    kind.insert(kind.end(), drops[k].eps.begin(), drops[k].eps.end());
  }
  const KindsOfDrops kinds{static_cast<std::size_t>(below), static_cast<std::size_t>(n - below),
                           median(std::move(lower)), median(std::move(upper))};
  // also as they are: a slope that few bounces tell parts what was dropped from two heights
  const double apart = kinds.eps_upper - kinds.eps_lower;
  if (apart < std::max(kFarApart * scatter.sd, kBeyondCurvature * (1.0 - kinds.eps_lower))) return {};
  return kinds;
}

std::vector<RepeatedDrop> repeated_drops(const RestitutionSamples& samples) {
  constexpr std::size_t kFewestBounces = 4;
  constexpr double kAlike = 0.1;  // of the scatter
  constexpr double kMostOfDrop = 0.8;
  constexpr std::size_t kNeighbours = 50;  // looked at: where more have one speed it tells nothing
  std::map<std::pair<std::string, std::int64_t>, std::size_t> numbers;
  std::vector<std::size_t> drop_of, first_of, size_of;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::size_t d = numbers.try_emplace({samples[k].recording, samples[k].drop}, numbers.size()).first->second;
    if (d == size_of.size()) {
      first_of.push_back(k);
      size_of.push_back(0);
    }
    drop_of.push_back(d);
    ++size_of[d];
  }
  if (size_of.size() < 2) return {};
  std::vector<Drop> drops = drops_of(samples);
  const Scatter scatter = bring_to_one_speed(drops);
  const double within = kAlike * scatter.sd;
  // times so coarse are alike of drops that are not
  if (timing_of(samples) > 0.5 * scatter.sd) return {};
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return samples[a].v_mps < samples[b].v_mps; });
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> alike;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < std::min(order.size(), i + 1 + kNeighbours); ++j) {
      const RestitutionSample &a = samples[order[i]], &b = samples[order[j]];
      if (b.v_mps - a.v_mps > within * a.v_mps) break;
      const std::size_t first = drop_of[order[i]], second = drop_of[order[j]];
      if (first != second && std::abs(a.eps - b.eps) <= within) ++alike[std::minmax(first, second)];
    }
  std::vector<RepeatedDrop> repeated;
  std::vector<bool> is_told(size_of.size(), false);
  for (const auto& [pair, n] : alike) {
    const auto [of, drop] = pair;
    const auto shorter = static_cast<double>(std::min(size_of[of], size_of[drop]));
    if (is_told[drop] || n < kFewestBounces || static_cast<double>(n) < kMostOfDrop * shorter) continue;
    is_told[drop] = true;
    const RestitutionSample &here = samples[first_of[drop]], &there = samples[first_of[of]];
    repeated.push_back({here.recording, there.recording, here.drop, there.drop, n});
  }
  return repeated;
}

}  // namespace bouncelab::fit
