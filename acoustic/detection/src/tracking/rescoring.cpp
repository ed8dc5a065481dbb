// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
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

/// A track's own sounds, with what it explains not counted among their neighbours.
struct OwnSounds {
  std::vector<std::size_t> candidates;  ///< indices, rising
  std::vector<std::size_t> explained;   ///< these, their echoes, and what other tracks explain, rising
  std::vector<Observation> seen;        ///< of each
  std::vector<double> same_source;      ///< weight of one source of each and the next
  std::vector<int> n_missing;           ///< impacts between each and the next that were not detected

  /// Takes a hypothesis from impact n up to another. @return whether a ball does that
  bool follow(std::size_t n, std::size_t last, Hypothesis& h) const {
    for (; n < last; ++n) {
      const auto step = h.step_to(seen[n + 1], n_missing[n], same_source[n], false);
      if (!step) return false;
      h.take(*step, seen[n + 1]);
    }
    return true;
  }
};

OwnSounds own_sounds(const Observations& o, const Track& track, const std::vector<std::size_t>& by_others) {
  OwnSounds own;
  for (const TrackImpact& impact : track.impacts) own.candidates.push_back(impact.candidate);
  own.explained = united(explained_by(o, track), by_others);
  for (std::size_t n = 0; n < own.candidates.size(); ++n) {
    own.seen.push_back(o.without(own.candidates[n], own.explained));
    if (n == 0) continue;
    own.same_source.push_back(o.same_source(own.candidates[n - 1], own.candidates[n]));
    own.n_missing.push_back(static_cast<int>(track.impacts[n].impact - track.impacts[n - 1].impact - 1));
  }
  return own;
}

/// The first impact was chosen before the ball was known, and those before it may have cost odds then: now it stands
/// for choice again, and impacts before it are looked for.
/// @param first_free  candidates before this one belong to the track before
/// @return whether the track has changed
bool re_estimate_start(const Observations& o, std::size_t first_free, Track& track) {
  const std::vector<Candidate>& c = o.candidates();
  const std::size_t first_before = track.impacts.front().candidate, n_before = track.impacts.size();
  std::optional<std::size_t> given;
  if (track.impacts.size() > kTracking.known_after && track.impacts[1].impact == track.impacts[0].impact + 1) {
    given = track.impacts[0].candidate;
    track.impacts.erase(track.impacts.begin());
  }
  while (track.impacts[1].impact == track.impacts[0].impact + 1) {
    const std::optional<Expected> expected = expected_before(c, track);
    if (!expected) break;
    const std::vector<std::size_t> explained = explained_by(o, track);
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
  return track.impacts.size() != n_before || track.impacts.front().candidate != first_before;
}

/// Sounds among a track's that are like its own and about as loud, but not of it: a ball leaves none, a row of knocks
/// or steps in which intervals happen to shrink, many. Echoes of its own do not count.
double n_unexplained(const Observations& o, const OwnSounds& sounds) {
  const std::vector<std::size_t>& own = sounds.candidates;
  const std::vector<Candidate>& c = o.candidates();
  const double begin_s = c[own[0]].t_s - kTracking.row_flights * (c[own[1]].t_s - c[own[0]].t_s);
  const double end_s = c[own.back()].t_s + kTracking.row_flights * (c[own.back()].t_s - c[own[own.size() - 2]].t_s);
  double n = 0.0;
  std::size_t next = 0;  // own sound that comes after
  const auto first = std::partition_point(c.begin(), c.end(), [&](const Candidate& s) { return s.t_s < begin_s; });
  for (auto k = static_cast<std::size_t>(first - c.begin()); k < c.size() && c[k].t_s < end_s; ++k) {
    while (next < own.size() && own[next] < k) ++next;
    if (next < own.size() && own[next] == k) continue;
    if (std::binary_search(sounds.explained.begin(), sounds.explained.end(), k)) continue;
    const std::size_t near = own[next > 0 ? next - 1 : 0];
    const bool is_echo = next > 0 && c[k].t_s - c[near].t_s < kTracking.echo_s;
    const bool is_same = next < own.size() && c[own[next]].t_s - c[k].t_s < kTracking.same_sound_s;
    if (!is_echo && !is_same && c[k].amplitude > kTracking.as_loud * c[near].amplitude)
      n += std::max(0.0, 2.0 * o.same_source_probability(near, k) - 1.0);
  }
  return n;
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

std::vector<std::size_t> united(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  std::vector<std::size_t> both;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

std::vector<std::size_t> explained_by(const Observations& o, const Track& track) {
  const std::vector<Candidate>& c = o.candidates();
  const std::vector<TrackImpact>& own = track.impacts;
  const auto t_s = [&](std::size_t n) { return c[own[n].candidate].t_s; };
  std::vector<std::size_t> explained;
  for (std::size_t n = 0; n < own.size(); ++n) {
    const double flight_s = n + 1 == own.size() ? t_s(n) - t_s(n - 1) : t_s(n + 1) - t_s(n);
    const double echo_s = std::min(kTracking.echo_s, kTracking.echo_of_flight * flight_s);
    const std::size_t first = own[n].candidate;
    explained.push_back(first);
    for (std::size_t k = first + 1; k < c.size() && c[k].t_s - t_s(n) < echo_s; ++k)
      if (c[k].amplitude < c[first].amplitude) explained.push_back(k);
  }
  return explained;
}

std::vector<std::size_t> explained_by_others(const Observations& o, const std::vector<Track>& tracks, std::size_t but) {
  std::vector<std::size_t> explained;
  for (std::size_t t = 0; t < tracks.size(); ++t)
    if (t != but &&
        (but == tracks.size() || !(ends_before(tracks[t], tracks[but]) || ends_before(tracks[but], tracks[t]))))
      explained = united(explained, explained_by(o, tracks[t]));
  return explained;
}

LogOdds log_odds_of(const Observations& o, const Track& track, const std::vector<std::size_t>& by_others) {
  const OwnSounds own = own_sounds(o, track, by_others);
  Hypothesis h = Hypothesis::begin(own.seen[0], own.seen[1], own.same_source[0], false);
  if (!own.follow(1, own.seen.size() - 1, h)) return {};
  const double less = kTracking.unexplained * n_unexplained(o, own);
  return {h.log_odds_of_losing_ball() - less, h.log_odds_of_ball() - less};
}

std::vector<Track> rescored(const Observations& o, std::vector<Track> tracks) {
  for (Track& track : tracks) track.log_odds = log_odds_of(o, track, {}).ball_against_rhythm;
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
    if (re_estimate_start(o, first_free, track)) track.log_odds = log_odds_of(o, track, {}).ball_against_rhythm;
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

namespace {

// impacts after which a hypothesis without one goes on as the track does: its next interval and ratio are the same
constexpr std::size_t kFollowed = 3;
constexpr std::size_t kBegins = 8;       // first impacts at which the track may begin instead: the model's memory
constexpr double kNegligible = -12.0;    // log weight of a hypothesis that changes no probability by a millionth
constexpr double kOwnSounds = 5.0;       // nats that the track's own sounds, counted as clutter, may cost a candidate
constexpr double kMostLogWeight = 30.0;  // against the track itself; exp(more) would only hide the others

double weight(double log_weight) { return log_weight < kNegligible ? 0.0 : exp(std::min(log_weight, kMostLogWeight)); }

using Step = Hypothesis::Step;

/// The hypotheses about one track. Log weights are those against the track.
class Alternatives {
 public:
  Alternatives(const Observations& o, const Track& track, const std::vector<std::size_t>& by_others)
      : o_(o), by_others_(by_others), own_(own_sounds(o, track, by_others)) {
    for (const TrackImpact& impact : track.impacts) number_.push_back(impact.impact);
    up_to_.reserve(number_.size());
    up_to_.push_back(begun(0, 1));
    for (std::size_t n = 2; n < size(); ++n) {
      Hypothesis h = up_to_.back();
      if (!own_.follow(n - 1, n, h)) break;
      up_to_.push_back(h);
    }
  }

  bool is_whole() const { return up_to_.size() + 1 == size(); }

  /// Ended before impact n, which is at least the third.
  double ended_before(std::size_t n) const { return log_odds(n - 1) - log_odds(size() - 1); }

  /// Begun at impact n, at least two before the last.
  double begun_at(std::size_t n) const { return followed(begun(n, n + 1), n + 1, kBegins); }

  double without(std::size_t n) const {
    const std::size_t next = n + 1;
    if (n == 1) return n_missing(0, 2) == 1 ? followed(begun(0, next), next, kFollowed) : -INFINITY;
    if (n_missing(n - 1, next) > kMostMissing) return -INFINITY;
    return taken(hypothesis(n - 1), step_to(hypothesis(n - 1), n - 1, next, least(next)), next, kFollowed);
  }

  /// Sum of the weights with other candidates in the place of n.
  double in_place_of(std::size_t n) const {
    const std::vector<Candidate>& c = o_.candidates();
    const std::size_t own = own_.candidates[n];
    double sum = 0.0;
    const auto take = [&](std::size_t k) {
      if (std::binary_search(by_others_.begin(), by_others_.end(), k)) return;
      if (std::abs(c[k].t_s - c[own].t_s) > std::max({c[k].reach_s, c[own].reach_s, kTracking.same_sound_s}))
        sum += weight(replaced(n, k));
    };
    const bool is_last = n + 1 == size();
    const double first_s = n > 0 ? c[own_.candidates[n - 1]].t_s : c[own].t_s - furthest_s(0);
    const double last_s = is_last ? c[own].t_s + furthest_s(n - 1) : c[own_.candidates[n + 1]].t_s;
    for (std::size_t k = own; k-- > 0 && c[k].t_s > first_s;) take(k);
    for (std::size_t k = own + 1; k < c.size() && c[k].t_s < last_s; ++k) take(k);
    return sum;
  }

 private:
  std::size_t size() const { return number_.size(); }
  /// Not detected between two impacts.
  int n_missing(std::size_t from, std::size_t to) const { return static_cast<int>(number_[to] - number_[from] - 1); }
  const Hypothesis& hypothesis(std::size_t n) const { return up_to_[n - 1]; }
  double log_odds(std::size_t n) const { return n > 0 ? hypothesis(n).log_odds : 0.0; }
  /// Log odds below which a hypothesis that has reached impact n is of no interest.
  double least(std::size_t n) const { return log_odds(n) + kNegligible; }

  /// The flight after impact n; beyond the first and the last none is longer.
  double furthest_s(std::size_t n) const {
    const double flight_s = own_.seen[n + 1].t_s - own_.seen[n].t_s;
    return n == 0 ? std::min(kLongestFlight_s, flight_s / kLeastEps) - flight_s : flight_s;
  }

  Hypothesis begun(std::size_t first, std::size_t second) const {
    return Hypothesis::begin(own_.seen[first], own_.seen[second], same_source(first, second), false);
  }
  double same_source(std::size_t j, std::size_t k) const {
    return k == j + 1 ? own_.same_source[j] : o_.same_source(own_.candidates[j], own_.candidates[k]);
  }
  std::optional<Step> step_to(const Hypothesis& h, std::size_t from, std::size_t to, double least) const {
    return h.step_to(own_.seen[to], n_missing(from, to), same_source(from, to), false, least);
  }

  /// Log weight of a hypothesis that has reached impact n, over as many more of the track's.
  double followed(Hypothesis h, std::size_t n, std::size_t n_more) const {
    const std::size_t last = std::min(size() - 1, n + n_more);
    return own_.follow(n, last, h) ? h.log_odds - log_odds(last) : -INFINITY;
  }

  /// The same of what a step makes of a hypothesis, if it is possible.
  double taken(Hypothesis h, const std::optional<Step>& step, std::size_t n, std::size_t n_more) const {
    if (!step) return -INFINITY;
    h.take(*step, own_.seen[n]);
    return followed(h, n, n_more);
  }

  /// Log weight with candidate k in the place of n.
  double replaced(std::size_t n, std::size_t k) const {
    const auto source = [&](std::size_t own) { return o_.same_source(own_.candidates[own], k); };
    if (n == 0)
      return followed(Hypothesis::begin(o_.without(k, own_.explained), own_.seen[1], source(1), false), 1, kFollowed);
    std::optional<Hypothesis> h;
    if (n == 1) {
      h = Hypothesis::begin(own_.seen[0], o_.without(k, own_.explained), source(0), false);
    } else {
      h = hypothesis(n - 1);
      const double of_source = source(n - 1);
      // whether it is worth the count of its neighbours without the track's own
      if (!h->step_to(o_[k], n_missing(n - 1, n), of_source, false, least(n) - kOwnSounds)) return -INFINITY;
      const Observation seen = o_.without(k, own_.explained);
      const std::optional<Step> step = h->step_to(seen, n_missing(n - 1, n), of_source, false, least(n));
      if (!step) return -INFINITY;
      h->take(*step, seen);
    }
    if (n + 1 == size()) return h->log_odds - log_odds(n);
    const std::optional<Step> step = h->step_to(own_.seen[n + 1], n_missing(n, n + 1), source(n + 1), false, -INFINITY);
    return taken(*h, step, n + 1, kFollowed - 1);
  }

  const Observations& o_;
  const std::vector<std::size_t>& by_others_;
  OwnSounds own_;
  std::vector<std::int64_t> number_;  ///< of each impact in the track
  std::vector<Hypothesis> up_to_;     ///< from the second impact on
};

}  // namespace

void set_impact_probabilities(const Observations& o, Track& track, const std::vector<std::size_t>& by_others) {
  const Alternatives alternatives(o, track, by_others);
  const std::size_t size = track.impacts.size();
  if (!alternatives.is_whole()) return;
  std::vector<double> ended(size, 0.0), begun(size, 0.0);  // weights of the track that ends before, or begins at, each
  for (std::size_t n = 2; n < size; ++n) ended[n] = weight(alternatives.ended_before(n));
  for (std::size_t n = 1; n < std::min(kBegins, size - 1); ++n) begun[n] = weight(alternatives.begun_at(n));
  double ended_later = 0.0, ended_here = 0.0, begun_later = 0.0, begun_here = 0.0;
  for (const double w : ended) ended_later += w;
  for (const double w : begun) begun_later += w;
  for (std::size_t n = 0; n < size; ++n) {
    ended_later -= ended[n], ended_here += ended[n];
    begun_later -= begun[n], begun_here += begun[n];
    const bool is_inner = n > 0 && n + 1 < size;
    const double with = 1.0 + std::max(0.0, ended_later) + begun_here;
    const double without = ended_here + std::max(0.0, begun_later) + alternatives.in_place_of(n) +
                           (is_inner ? weight(alternatives.without(n)) : 0.0);
    track.impacts[n].probability = with / (with + without);
  }
}

double probability_of_inferred(double llr, double n_places) {
  return 1.0 / (1.0 + n_places * exp(-llr) + kTracking.other_sound);
}

bool is_at_candidate(const std::vector<Candidate>& c, double t_s) {
  constexpr double kFar_s = 48e-3;  // the longest window
  auto k = std::partition_point(c.begin(), c.end(), [&](const Candidate& other) { return other.t_s < t_s - kFar_s; });
  for (; k != c.end() && k->t_s < t_s + kFar_s; ++k)
    if (std::abs(k->t_s - t_s) < std::max(kTracking.rise_of_template_s, k->reach_s)) return true;
  return false;
}

double probability_of_mark(double log_odds, double of_impact) {
  constexpr double kDecimals = 1e6;
  return std::round(kDecimals * of_impact / (1.0 + exp(-log_odds))) / kDecimals;
}

}  // namespace bouncelab::detection
