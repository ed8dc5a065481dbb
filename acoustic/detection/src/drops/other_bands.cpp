// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/other_bands.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "delay/delay_model.hpp"
#include "drops/drops_model.hpp"

namespace bouncelab::detection {
namespace {

using TimedImpacts = std::vector<TimedImpact>;

/// An impact that both bands show.
struct Shared {
  std::size_t own = 0, theirs = 0;
  double later_s = 0.0;  // in the own band
};

double shorter_interval(const TimedImpacts& impacts, std::size_t k) {
  const double before_s = k > 0 ? impacts[k].fit.t_s - impacts[k - 1].fit.t_s : INFINITY;
  const double after_s = k + 1 < impacts.size() ? impacts[k + 1].fit.t_s - impacts[k].fit.t_s : INFINITY;
  return std::min(before_s, after_s);
}

/// Pairs of impacts that are nearest to each other, less than a quarter of the intervals and reach_s from later_s.
std::vector<Shared> shared_impacts(const TimedImpacts& own, const TimedImpacts& theirs, double later_s,
                                   double reach_s) {
  std::vector<Shared> shared;
  std::size_t j = 0;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const auto off_s = [&](std::size_t other) { return own[k].fit.t_s - theirs[other].fit.t_s - later_s; };
    while (j + 1 < theirs.size() && std::abs(off_s(j + 1)) < std::abs(off_s(j))) ++j;
    const double most_s =
        std::min(reach_s, kDrops.same_of_interval * std::min(shorter_interval(own, k), shorter_interval(theirs, j)));
    if (std::abs(off_s(j)) > most_s || (!shared.empty() && shared.back().theirs == j)) continue;
    shared.push_back({k, j, off_s(j) + later_s});
  }
  return shared;
}

double median_later_s(const std::vector<Shared>& shared) {
  std::vector<double> later_s;
  for (const Shared& s : shared) later_s.push_back(s.later_s);
  return upper_median(std::move(later_s));
}

std::vector<Shared> shared_impacts(const TimedImpacts& own, const TimedImpacts& theirs) {
  if (own.empty() || theirs.empty()) return {};
  const std::vector<Shared> rough = shared_impacts(own, theirs, 0.0, kDrops.most_delay_s);
  if (rough.size() < kDrops.fewest_shared) return {};
  std::vector<Shared> shared = shared_impacts(own, theirs, median_later_s(rough), kDelay.least_interval_s);
  if (shared.size() < kDrops.fewest_shared || 2 * shared.size() < std::min(own.size(), theirs.size())) return {};
  return shared;
}

/// What takes an impact of the other band to this one.
struct Transfer {
  double later_s = 0.0, sigma_s = 0.0;
  double gain = 1.0;  // of the amplitude
};

/// By the shared impacts nearest to number `next`, the first after it.
Transfer transfer_at(const std::vector<Shared>& shared, std::size_t next, const TimedImpacts& own,
                     const TimedImpacts& theirs) {
  const std::size_t n = std::min(kDrops.nearest_shared, shared.size());
  const std::size_t first = std::min(next > n / 2 ? next - n / 2 : 0, shared.size() - n);
  std::vector<double> later_s, gain, off_s;
  for (std::size_t k = first; k < first + n; ++k) {
    later_s.push_back(shared[k].later_s);
    const double amplitude = theirs[shared[k].theirs].fit.amplitude;
    if (amplitude > 0.0) gain.push_back(own[shared[k].own].fit.amplitude / amplitude);
  }
  Transfer transfer;
  transfer.later_s = upper_median(later_s);
  for (const double s : later_s) off_s.push_back(std::abs(s - transfer.later_s));
  constexpr double kToSigma = 1.4826, kOfMedian = 1.2533;  // of a normal distribution
  transfer.sigma_s = kToSigma * kOfMedian * upper_median(std::move(off_s)) / std::sqrt(static_cast<double>(n));
  if (!gain.empty()) transfer.gain = upper_median(std::move(gain));
  return transfer;
}

/// Number of the other band's impact j in this one; absent where the shared impacts on either side disagree.
std::optional<std::int64_t> number_of(const std::vector<Shared>& shared, std::size_t next, std::size_t j,
                                      const TimedImpacts& own, const TimedImpacts& theirs) {
  const auto more = [&](std::size_t k) { return own[shared[k].own].impact - theirs[shared[k].theirs].impact; };
  const bool is_after_one = next > 0, is_before_one = next < shared.size();
  if (is_after_one && is_before_one && more(next - 1) != more(next)) return {};
  return theirs[j].impact + more(is_after_one ? next - 1 : next);
}

/// Time of one flight between two impacts of known numbers, if they are there.
double flight_s(const TimedImpacts& impacts, std::size_t before, std::size_t after) {
  if (after >= impacts.size()) return 0.0;
  return (impacts[after].fit.t_s - impacts[before].fit.t_s) /
         static_cast<double>(std::max<std::int64_t>(1, impacts[after].impact - impacts[before].impact));
}

/// Puts it at its number, where that is free and its neighbours are as far as its flights say.
bool insert(const TimedImpact& impact, double before_s, double after_s, TimedImpacts& impacts) {
  const auto at = std::partition_point(impacts.begin(), impacts.end(),
                                       [&](const TimedImpact& other) { return other.impact < impact.impact; });
  if (at != impacts.end() &&
      (at->impact == impact.impact ||
       at->fit.t_s - impact.fit.t_s < std::max(kDelay.least_interval_s, kDrops.least_of_flight * after_s)))
    return false;
  if (at != impacts.begin() &&
      impact.fit.t_s - (at - 1)->fit.t_s < std::max(kDelay.least_interval_s, kDrops.least_of_flight * before_s))
    return false;
  impacts.insert(at, impact);
  return true;
}

}  // namespace

std::size_t add_impacts_of_other_band(const TimedDrop& other, double begin_s, double end_s, TimedDrop& drop) {
  const TimedImpacts& theirs = other.impacts;
  const TimedImpacts own = drop.impacts;
  const std::vector<Shared> shared = shared_impacts(own, theirs);
  if (shared.empty()) return 0;
  const bool may_infer = is_reliable(other.correlation) && !is_reliable(drop.correlation);
  std::size_t n_added = 0, next = 0;
  for (std::size_t j = 0; j < theirs.size(); ++j) {
    while (next < shared.size() && shared[next].theirs < j) ++next;
    if (next < shared.size() && shared[next].theirs == j) continue;
    if (theirs[j].inferred && !may_infer) continue;
    const std::optional<std::int64_t> number = number_of(shared, next, j, own, theirs);
    if (!number) continue;
    const Transfer transfer = transfer_at(shared, next, own, theirs);
    TimedImpact impact = theirs[j];
    impact.impact = *number;
    impact.fit.t_s += transfer.later_s;
    impact.fit.sigma_s = hypot(impact.fit.sigma_s, transfer.sigma_s);
    impact.fit.amplitude *= transfer.gain;
    impact.v_mps = 0.0;
    const double before_s = j > 0 ? flight_s(theirs, j - 1, j) : 0.0, after_s = flight_s(theirs, j, j + 1);
    if (!(impact.fit.t_s - before_s > begin_s && impact.fit.t_s + after_s < end_s)) continue;
    if (insert(impact, before_s, after_s, drop.impacts)) ++n_added;
  }
  const std::int64_t first = drop.impacts.front().impact;
  if (first < 0)
    for (TimedImpact& impact : drop.impacts) impact.impact -= first;
  return n_added;
}

}  // namespace bouncelab::detection
