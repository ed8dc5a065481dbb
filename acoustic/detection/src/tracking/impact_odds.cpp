// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/impact_odds.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/rescoring.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
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
  Alternatives(const Observations& o, const Track& track) : o_(o), own_(own_sounds(o, track)) {
    for (const TrackImpact& impact : track.impacts) number_.push_back(impact.impact);
    up_to_.reserve(number_.size());
    up_to_.push_back(begun(0, 1));
    for (std::size_t n = 2; n < size(); ++n) {
      const std::optional<Step> step = step_to(up_to_.back(), n - 1, n, -INFINITY);
      if (!step) break;
      up_to_.push_back(up_to_.back());
      up_to_.back().take(*step, own_.seen[n]);
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
    if (n == last) return h.log_odds - log_odds(n);
    for (;;) {
      const std::optional<Step> step = step_to(h, n, n + 1, -INFINITY);
      if (!step) return -INFINITY;
      if (++n == last) return step->log_odds - log_odds(last);
      h.take(*step, own_.seen[n]);
    }
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
  OwnSounds own_;
  std::vector<std::int64_t> number_;  ///< of each impact in the track
  std::vector<Hypothesis> up_to_;     ///< from the second impact on
};

}  // namespace

void set_impact_probabilities(const Observations& o, Track& track) {
  const Alternatives alternatives(o, track);
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
