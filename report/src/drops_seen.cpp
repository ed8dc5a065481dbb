// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/report/answer.hpp"
namespace bouncelab::report {
using namespace fit;
namespace {

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double gravity_of(const RestitutionSample& s) { return s.conditions.gravity_mps2.value_or(kDefaultGravity_mps2); }
/// The interval that ended with the sample's impact, eq. 2.
double interval_before_s(const RestitutionSample& s) { return 2.0 * s.v_mps / gravity_of(s); }
bool is_sound(const RestitutionSample& s) {
  return std::isfinite(s.v_mps) && std::isfinite(s.eps) && std::isfinite(s.t_s) && s.v_mps > 0.0;
}

/// @param drop  ordered by impact number, times increasing
std::optional<double> height_of(const std::vector<const RestitutionSample*>& drop) {
  constexpr std::size_t kFirstBounces = 5;  // their median: a single eps may be wrong
  const RestitutionSample& first = *drop.front();
  if (!first.flags.empty() || first.impact > 1) return {};
  double v0_mps = first.v_mps, t0_s = first.t_s;
  if (first.impact == 1) {
    std::vector<double> eps;
    for (const RestitutionSample* s : drop)
      if (s->flags.empty() && s->eps > 0.0 && s->eps < 1.0 && eps.size() < kFirstBounces) eps.push_back(s->eps);
    if (eps.empty()) return {};
    v0_mps = first.v_mps / median_of(eps);
    t0_s = first.t_s - interval_before_s(first);
  }
  // a bounce before this one would have been at t0 - 2 v0/g: if that is before the recording began, or so near that eps
  // and drag decide, nothing is known of it. A sample of impact 0 is there only where the height of release was given.
  constexpr double kClearly = 1.2;
  if (first.impact == 1 && t0_s < kClearly * 2.0 * v0_mps / gravity_of(first)) return {};
  return v0_mps * v0_mps / (2.0 * gravity_of(first));
}

/// Those of the samples and on either side of each. @param drop  ordered by impact number
std::size_t n_impacts_of(const std::vector<const RestitutionSample*>& drop) {
  std::size_t n = 0;
  std::int64_t next = 0;  // smallest number not counted yet
  for (const RestitutionSample* s : drop) {
    const std::int64_t first = std::max(next, s->impact - 1);
    n += static_cast<std::size_t>(std::max<std::int64_t>(0, s->impact + 2 - first));
    next = std::max(next, s->impact + 2);
  }
  return n;
}

}  // namespace

DropsSeen drops_seen(const RestitutionSamples& samples) {
  std::map<std::pair<std::string, std::int64_t>, std::vector<const RestitutionSample*>> drops;
  auto present = drops.end();  // successive samples are mostly of one drop
  for (const RestitutionSample& s : samples) {
    if (!is_sound(s)) continue;
    if (present == drops.end() || present->first.second != s.drop || present->first.first != s.recording)
      present = drops.try_emplace({s.recording, s.drop}).first;
    present->second.push_back(&s);
  }
  DropsSeen seen;
  seen.n_drops = drops.size();
  const DropsSeen untimed = seen;
  std::size_t n_impacts = 0;
  double duration_s = 0.0;
  std::vector<double> heights_m;
  for (auto& [name, drop] : drops) {
    std::stable_sort(drop.begin(), drop.end(), [](const auto* a, const auto* b) { return a->impact < b->impact; });
    const bool timed = drop.front()->t_s > 0.0 && std::adjacent_find(drop.begin(), drop.end(), [](auto* a, auto* b) {
                                                    return a->impact == b->impact || a->t_s >= b->t_s;
                                                  }) == drop.end();
    if (!timed) return untimed;  // a table of speeds and eps alone
    n_impacts += n_impacts_of(drop);
    const RestitutionSample &first = *drop.front(), &last = *drop.back();
    duration_s += last.t_s + std::max(0.0, last.eps) * interval_before_s(last) - first.t_s;
    if (first.impact > 0) duration_s += interval_before_s(first);
    if (const std::optional<double> h = height_of(drop)) heights_m.push_back(*h);
  }
  if (drops.empty()) return seen;
  seen.n_impacts = n_impacts;
  seen.duration_s = duration_s;
  seen.n_heights = heights_m.size();
  if (!heights_m.empty()) seen.drop_height_m = median_of(std::move(heights_m));
  return seen;
}

}  // namespace bouncelab::report
