// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/predicted_places.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "timing/delay_posterior.hpp"
#include "timing/merged_fit.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kMaxTurns = 3;             // a wrong place moves what is expected of both neighbours
constexpr double kUnexpected = 4.0;      // standard deviations
constexpr double kMaxOfInterval = 0.25;  // of either interval: what is further off is the neighbour's

using TimedImpacts = std::vector<TimedImpact>;

std::vector<double> times_of(const TimedImpacts& track) {
  std::vector<double> t_s;
  for (const TimedImpact& impact : track) t_s.push_back(impact.fit.t_s);
  return t_s;
}

struct ExpectedTime {
  double t_s = 0.0;
  double sigma_s = 0.0;
};

/// Of impact k between its neighbours, D apart: t = t_{k-1} + D / (1 + eps).
ExpectedTime expected_time(const ExpectedLogEps& log_eps, double before_s, double after_s) {
  const double eps = exp(log_eps.centre);
  const double both_s = after_s - before_s;
  return {before_s + both_s / (1.0 + eps), both_s * eps / square(1.0 + eps) * log_eps.width};
}

/// The places that the sound has where an impact is expected; absent where it is there.
std::optional<ImpactFit> find_where_expected(Search& search, const TimedImpacts& track, std::size_t k,
                                             const ExpectedLogEps& log_eps) {
  const double before_s = track[k - 1].fit.t_s, here_s = track[k].fit.t_s, after_s = track[k + 1].fit.t_s;
  if (log_eps.width == 0.0 || !(before_s < here_s && here_s < after_s)) return {};
  const ExpectedTime expected = expected_time(log_eps, before_s, after_s);
  const double reach_s = kUnexpected * expected.sigma_s;
  if (std::abs(here_s - expected.t_s) < reach_s) return {};
  const double most_s = kMaxOfInterval * std::min(expected.t_s - before_s, after_s - expected.t_s);
  return find_impact(search, expected.t_s, std::min(reach_s, most_s), after_s);
}

/// @return whether an impact is at another place now
bool add_places_once(const Search& search, TimedImpacts& track) {
  const std::vector<ExpectedLogEps> expected = expected_log_eps(track, times_of(track));
  const double same_s = 1.0 / search.white.source().rate_hz;
  Search again{search.white, search.learned, ImpactTimer(search.white, search.learned), search.template_s};
  bool has_moved = false;
  for (std::size_t k = 0; k < track.size(); ++k) {
    if (k > 0 && k + 1 < track.size())
      if (const auto found = find_where_expected(again, track, k, expected[k])) {
        const double before_s = track[k].fit.t_s;
        track[k].fit = merged(with_fewer_places(track[k].fit), with_fewer_places(*found), same_s);
        has_moved = has_moved || track[k].fit.t_s != before_s;
      }
    again.timer.subtract_from_later(track[k].fit);
  }
  return has_moved;
}

}  // namespace

void add_predicted_places(const Search& search, std::vector<TimedImpact>& track) {
  for (int turn = 0; turn < kMaxTurns && add_places_once(search, track); ++turn) {
  }
}

}  // namespace bouncelab::detection
