// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/report/answer.hpp"
namespace bouncelab::report {
using namespace fit;
namespace {

double gravity_of(const RestitutionSample& s) { return s.conditions.gravity_mps2.value_or(kDefaultGravity_mps2); }
/// The interval that ended with the sample's impact, eq. 2.
double interval_before_s(const RestitutionSample& s) { return 2.0 * s.v_mps / gravity_of(s); }
bool is_sound(const RestitutionSample& s) {
  return std::isfinite(s.v_mps) && std::isfinite(s.eps) && std::isfinite(s.t_s) && s.v_mps > 0.0;
}

using Drop = std::vector<const RestitutionSample*>;  ///< ordered by impact number, times increasing

double begin_s(const Drop& drop) {
  const RestitutionSample& first = *drop.front();
  return first.impact > 0 ? first.t_s - interval_before_s(first) : first.t_s;
}
double end_s(const Drop& drop) {
  const RestitutionSample& last = *drop.back();
  return last.t_s + std::max(0.0, last.eps) * interval_before_s(last);
}

/// Height of the drop's release; absent where it is not known that the first impact seen was the first.
/// @param height    by the fit, which has left out a first sample that is flagged or unlike the others
/// @param silent_s  when the recording began, or another drop's last impact before this one
std::optional<Estimate> height_of(const Drop& drop, const Estimate* height, double silent_s) {
  const RestitutionSample& first = *drop.front();
  if (first.impact == 0) {  // the height was given
    Estimate given;
    given.value = first.v_mps * first.v_mps / (2.0 * gravity_of(first));
    return given;
  }
  if (!height) return {};
  // a flight of T rises g T^2/8, whether there is drag (to a thousandth) or not
  double highest_m = 0.0;
  for (const RestitutionSample* s : drop)
    highest_m = std::max(highest_m, square(s->v_mps * std::max(1.0, s->eps)) / (2.0 * gravity_of(*s)));
  if (height->value < highest_m) return {};
  // A bounce before this impact would have risen as high as the height of release, or higher, and would have been heard
  // in the silence. The detector needs some more of it before an impact.
  constexpr double kClearly = 1.2;
  if (begin_s(drop) - silent_s < kClearly * std::sqrt(8.0 * height->ci95->hi / gravity_of(first))) return {};
  Estimate proved = *height;
  proved.ci95->lo = std::max(proved.ci95->lo, highest_m);
  return proved;
}

/// Those of the samples and on either side of each, but for those that are not the ball's.
/// @param drop  ordered by impact number
std::size_t n_impacts_of(const Drop& drop) {
  std::size_t n = 0;
  std::int64_t next = 0;  // smallest number not counted yet
  for (const RestitutionSample* s : drop) {
    if (s->flags.has(Flag::improbable) || s->flags.has(Flag::extra_impact)) continue;
    const std::int64_t first = std::max(next, s->impact - 1);
    n += static_cast<std::size_t>(std::max<std::int64_t>(0, s->impact + 2 - first));
    next = std::max(next, s->impact + 2);
  }
  return n;
}

using Name = std::pair<std::string, std::int64_t>;  ///< recording, number of the drop

std::map<Name, Drop> by_drop(const RestitutionSamples& samples) {
  std::map<Name, Drop> drops;
  for (const RestitutionSample& s : samples)
    if (is_sound(s)) drops[{s.recording, s.drop}].push_back(&s);
  for (auto& [name, drop] : drops)
    std::stable_sort(drop.begin(), drop.end(), [](const auto* a, const auto* b) { return a->impact < b->impact; });
  return drops;
}

bool is_timed(const Drop& drop) {
  return drop.front()->t_s > 0.0 && std::adjacent_find(drop.begin(), drop.end(), [](auto* a, auto* b) {
                                      return a->impact == b->impact || a->t_s >= b->t_s;
                                    }) == drop.end();
}

void add_heights(const std::map<Name, Drop>& drops, const std::vector<ReleaseHeight>& of_fit, DropsSeen& seen) {
  std::map<Name, const Estimate*> by_fit;
  for (const ReleaseHeight& h : of_fit) by_fit[{h.recording, h.drop}] = &h.height_m;
  std::map<std::string, std::vector<double>> impacts_s;  // of a recording
  for (const auto& [name, drop] : drops) {
    std::vector<double>& times_s = impacts_s[name.first];
    for (const RestitutionSample* s : drop) times_s.push_back(s->t_s);
    times_s.insert(times_s.end(), {begin_s(drop), end_s(drop)});
  }
  for (auto& [recording, times_s] : impacts_s) std::sort(times_s.begin(), times_s.end());
  std::vector<double> values_m, lo_m, hi_m;
  for (const auto& [name, drop] : drops) {
    const std::vector<double>& times_s = impacts_s[name.first];
    const auto own = std::lower_bound(times_s.begin(), times_s.end(), begin_s(drop));
    const auto found = by_fit.find(name);
    const std::optional<Estimate> h = height_of(drop, found == by_fit.end() ? nullptr : found->second,
                                                own == times_s.begin() ? 0.0 : *std::prev(own));
    if (!h) continue;
    values_m.push_back(h->value);
    if (h->ci95) lo_m.push_back(h->ci95->lo), hi_m.push_back(h->ci95->hi);
  }
  seen.n_heights = values_m.size();
  if (values_m.empty()) return;
  const auto [least, greatest] = std::minmax_element(values_m.begin(), values_m.end());
  const Interval all{*least, *greatest};
  const double middle_m = median(std::move(values_m));
  seen.drop_height_m = middle_m;
  for (std::size_t k = 0; k < lo_m.size(); ++k)
    if (middle_m < lo_m[k] || middle_m > hi_m[k]) seen.drop_heights_m = all;
  if (seen.drop_heights_m) return;
  // what the drops have in common, drag and eps(v), does not average out: the median's interval is that of one drop
  if (!lo_m.empty()) seen.drop_height_ci95_m = Interval{median(std::move(lo_m)), median(std::move(hi_m))};
}

}  // namespace

DropsSeen drops_seen(const RestitutionSamples& samples, const std::vector<ReleaseHeight>& heights) {
  const std::map<Name, Drop> drops = by_drop(samples);
  DropsSeen seen;
  seen.n_drops = drops.size();
  const bool all_timed = std::all_of(drops.begin(), drops.end(), [](const auto& d) { return is_timed(d.second); });
  if (drops.empty() || !all_timed) return seen;  // a table of speeds and eps alone
  seen.n_impacts = 0;
  seen.duration_s = 0.0;
  for (const auto& [name, drop] : drops) {
    *seen.n_impacts += n_impacts_of(drop);
    *seen.duration_s += end_s(drop) - begin_s(drop);
  }
  add_heights(drops, heights, seen);
  return seen;
}

}  // namespace bouncelab::report
