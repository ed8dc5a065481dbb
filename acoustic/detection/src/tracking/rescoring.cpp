// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rescoring.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
namespace {

/// The coefficient of restitution that goes before the first of a track.
struct Expected {
  double log_eps = 0.0;
  double scatter = 0.0;
};

/// By the line through its first ones, which follows eps(v); a mean where they are few.
std::optional<Expected> expected_before(const std::vector<Candidate>& c, const Track& track) {
  std::vector<double> log_eps;
  for (std::size_t k = 1; k + 1 < kTracking.first_of_line; ++k)
    if (const std::optional<double> eps = eps_at(c, track, k)) log_eps.push_back(log(*eps));
  if (log_eps.size() < 2) return {};
  const auto n = static_cast<double>(log_eps.size());
  const double middle = 0.5 * (n - 1.0);
  const double mean = std::accumulate(log_eps.begin(), log_eps.end(), 0.0) / n;
  const double sum_x2 = n * (n * n - 1.0) / 12.0;
  double slope = 0.0;
  if (log_eps.size() >= kTracking.fewest_of_line)
    for (std::size_t k = 0; k < log_eps.size(); ++k) slope += (static_cast<double>(k) - middle) * log_eps[k] / sum_x2;
  double squares = 0.0;
  for (std::size_t k = 0; k < log_eps.size(); ++k) {
    const double off = log_eps[k] - mean - slope * (static_cast<double>(k) - middle);
    squares += off * off;
  }
  const double reach = middle + 1.0;
  if (log_eps.size() < kTracking.fewest_of_line)
    return Expected{mean, std::sqrt(squares / (n - 1.0) * (1.0 + 1.0 / n))};
  return Expected{mean - slope * reach, std::sqrt(squares / (n - 2.0) * (1.0 + 1.0 / n + reach * reach / sum_x2))};
}

/// A track's own sounds and their echoes: chance need not offer them.
/// @param own  two candidates or more, rising
/// @return indices, rising
std::vector<std::size_t> explained_by(const Observations& o, const std::vector<std::size_t>& own) {
  const std::vector<Candidate>& c = o.candidates();
  std::vector<std::size_t> explained;
  for (std::size_t n = 0; n < own.size(); ++n) {
    const bool is_last = n + 1 == own.size();
    const double flight_s = is_last ? c[own[n]].t_s - c[own[n - 1]].t_s : c[own[n + 1]].t_s - c[own[n]].t_s;
    const double echo_s = std::min(kTracking.echo_s, kTracking.echo_of_flight * flight_s);
    explained.push_back(own[n]);
    for (std::size_t k = own[n] + 1; k < c.size() && c[k].t_s - c[own[n]].t_s < echo_s; ++k)
      if (c[k].amplitude < c[own[n]].amplitude) explained.push_back(k);
  }
  return explained;
}

/// The first impact was chosen before the ball was known, and those before it may have cost odds then: now it stands
/// for choice again, and impacts before it are looked for.
/// @param first_free  candidates before this one belong to the track before
void re_estimate_start(const Observations& o, std::size_t first_free, Track& track) {
  const std::vector<Candidate>& c = o.candidates();
  std::optional<std::size_t> given;
  if (track.impacts.size() > kTracking.known_after && track.impacts[1].impact == track.impacts[0].impact + 1) {
    given = track.impacts[0].candidate;
    track.impacts.erase(track.impacts.begin());
  }
  const std::optional<Expected> expected = expected_before(c, track);
  std::vector<std::size_t> own;
  for (const TrackImpact& impact : track.impacts) own.push_back(impact.candidate);
  const std::vector<std::size_t> explained = explained_by(o, own);
  while (expected && track.impacts[1].impact == track.impacts[0].impact + 1) {
    const std::size_t first = track.impacts[0].candidate;
    const double flight_s = c[track.impacts[1].candidate].t_s - c[first].t_s;
    const auto odds_of = [&](std::size_t k) {
      return log_odds_before(o.without(k, explained), o[first], o.same_source(k, first), flight_s, expected->log_eps,
                             expected->scatter);
    };
    double best = given ? odds_of(*given) : 0.0;
    std::size_t before = given.value_or(first);
    const double furthest_s = std::min(kLongestFlight_s, flight_s / kLeastEps);
    for (std::size_t k = first; k-- > first_free && c[first].t_s - c[k].t_s < furthest_s;) {
      const double odds = odds_of(k);
      if (odds > best) best = odds, before = k;
    }
    if (before == first) break;
    track.impacts.insert(track.impacts.begin(), {before, track.impacts[0].impact - 1});
    given.reset();
  }
  if (given) track.impacts.insert(track.impacts.begin(), {*given, track.impacts[0].impact - 1});
  const std::int64_t shift = track.impacts.front().impact;
  for (TrackImpact& impact : track.impacts) impact.impact -= shift;
}

/// Sounds among a track's that are like its own and about as loud, but not of it: a ball leaves none, a row of knocks
/// or steps in which intervals happen to shrink, many. Echoes of its own do not count.
double n_unexplained(const Observations& o, const std::vector<std::size_t>& own) {
  const std::vector<Candidate>& c = o.candidates();
  const double begin_s = c[own[0]].t_s - kTracking.row_flights * (c[own[1]].t_s - c[own[0]].t_s);
  const double end_s = c[own.back()].t_s + kTracking.row_flights * (c[own.back()].t_s - c[own[own.size() - 2]].t_s);
  double n = 0.0;
  std::size_t next = 0;  // own sound that comes after
  const auto first = std::partition_point(c.begin(), c.end(), [&](const Candidate& s) { return s.t_s < begin_s; });
  for (auto k = static_cast<std::size_t>(first - c.begin()); k < c.size() && c[k].t_s < end_s; ++k) {
    while (next < own.size() && own[next] < k) ++next;
    if (next < own.size() && own[next] == k) continue;
    const std::size_t near = own[next > 0 ? next - 1 : 0];
    const bool is_echo = next > 0 && c[k].t_s - c[near].t_s < kTracking.echo_s;
    if (!is_echo && c[k].amplitude > kTracking.as_loud * c[near].amplitude)
      n += std::max(0.0, 2.0 * o.same_source_probability(near, k) - 1.0);
  }
  return n;
}

/// Log odds of a track where what it explains does not compete with its sounds.
double log_odds_of(const Observations& o, const Track& track) {
  const OwnSounds own = own_sounds(o, track);
  Hypothesis h = Hypothesis::begin(own.seen[0], own.seen[1], own.same_source[0], false);
  for (std::size_t n = 2; n < own.seen.size(); ++n) {
    const auto n_missing = static_cast<int>(track.impacts[n].impact - track.impacts[n - 1].impact - 1);
    const auto step = h.step_to(own.seen[n], n_missing, own.same_source[n - 1], false);
    if (!step) return -INFINITY;
    h.take(*step, own.seen[n]);
  }
  return h.log_odds_of_ball() - kTracking.unexplained * n_unexplained(o, own.candidates);
}

constexpr double kRateStep = 2.0;  // of the rates of drops that are averaged over

/// Windows with sounds enough for a track.
double n_windows(const std::vector<Candidate>& c) {
  double n = 0.0;
  for (std::size_t k = 0; k < c.size();) {
    const auto end = std::partition_point(c.begin() + static_cast<std::ptrdiff_t>(k), c.end(), [&](const Candidate& s) {
      return s.t_s < c[k].t_s + kTracking.birth_window_s;
    });
    const auto next = static_cast<std::size_t>(end - c.begin());
    if (next - k >= static_cast<std::size_t>(kFewestImpacts)) n += 1.0;
    k = next;
  }
  return std::max(1.0, n);
}

/// log(1 - p + p odds)
double log_evidence(double p, double log_odds) { return log_of_sum(log(p) + log_odds, log1p(-p)); }

bool ends_before(const Track& a, const Track& b) { return a.impacts.back().candidate < b.impacts.front().candidate; }

}  // namespace

OwnSounds own_sounds(const Observations& o, const Track& track) {
  OwnSounds own;
  for (const TrackImpact& impact : track.impacts) own.candidates.push_back(impact.candidate);
  own.explained = explained_by(o, own.candidates);
  for (std::size_t n = 0; n < own.candidates.size(); ++n) {
    own.seen.push_back(o.without(own.candidates[n], own.explained));
    if (n > 0) own.same_source.push_back(o.same_source(own.candidates[n - 1], own.candidates[n]));
  }
  return own;
}

std::vector<Track> rescored(const Observations& o, std::vector<Track> tracks) {
  for (Track& track : tracks) track.log_odds = log_odds_of(o, track);
  // the surest first: what its earlier impacts are, no other track may claim
  std::stable_sort(tracks.begin(), tracks.end(),
                   [](const Track& a, const Track& b) { return a.log_odds > b.log_odds; });
  std::vector<Track> kept;
  for (Track& track : tracks) {
    std::size_t first_free = 0;
    bool is_free = true;
    for (const Track& surer : kept) {
      if (ends_before(surer, track))
        first_free = std::max(first_free, surer.impacts.back().candidate + 1);
      else if (!ends_before(track, surer))
        is_free = false;
    }
    if (!is_free) continue;
    re_estimate_start(o, first_free, track);
    track.log_odds = log_odds_of(o, track);
    kept.push_back(std::move(track));
  }
  std::sort(kept.begin(), kept.end(), ends_before);
  return kept;
}

void weigh_by_drop_rate(const std::vector<Candidate>& candidates, std::vector<Track>& tracks) {
  if (tracks.empty()) return;
  const double n = std::max(n_windows(candidates), static_cast<double>(tracks.size()));
  const double most = 1.0 / (1.0 + exp(-kTracking.start_log_odds));
  struct Rate {
    double log_odds;  // of a ball in a window
    double log_weight;
  };
  std::vector<Rate> rates;
  for (double p = most; p > most / n / kRateStep; p /= kRateStep) {
    double log_weight = (n - static_cast<double>(tracks.size())) * log1p(-p);
    for (const Track& track : tracks) log_weight += log_evidence(p, track.log_odds - kTracking.start_log_odds);
    rates.push_back({log(p) - log1p(-p), log_weight});
  }
  const double largest = std::max_element(rates.begin(), rates.end(), [](const Rate& a, const Rate& b) {
                           return a.log_weight < b.log_weight;
                         })->log_weight;
  for (Track& track : tracks) {
    double ball = 0.0, none = 0.0;
    for (const Rate& rate : rates) {
      const double log_odds = track.log_odds - kTracking.start_log_odds + rate.log_odds;
      const double weight = exp(rate.log_weight - largest);
      ball += weight / (1.0 + exp(-log_odds));
      none += weight / (1.0 + exp(log_odds));
    }
    // beyond what is not to be told from certainty, the largest rate has all the weight or the track needs none
    if (none > 1e-12 * ball) track.log_odds = log(ball / none);
  }
}

}  // namespace bouncelab::detection
