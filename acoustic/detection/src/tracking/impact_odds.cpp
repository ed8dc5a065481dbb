// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/impact_odds.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "tracking/hypothesis.hpp"

namespace bouncelab::detection {
namespace {

// impacts after which a hypothesis without one goes on as the track does: its next interval and ratio are the same
constexpr std::size_t kFollowed = 3;
constexpr std::size_t kBegins = 8;       // first impacts at which the track may begin instead: the model's memory
constexpr double kNegligible = -12.0;    // log weight of a hypothesis that changes no probability by a millionth
constexpr double kOwnSounds = 5.0;       // nats that the track's own sounds, counted as clutter, may cost a candidate
constexpr double kMostLogWeight = 30.0;  // against the track itself; exp(more) would only hide the others

/// A track's impacts as the model sees them.
struct Impacts {
  std::vector<std::size_t> candidate;
  std::vector<std::int64_t> number;
  const std::vector<Observation>& seen;

  std::size_t size() const { return candidate.size(); }
  /// Not detected between two of them.
  int n_missing(std::size_t from, std::size_t to) const { return static_cast<int>(number[to] - number[from] - 1); }
};

double weight(double log_weight) { return log_weight < kNegligible ? 0.0 : exp(std::min(log_weight, kMostLogWeight)); }

/// The hypotheses about one track. Log weights are those against the track.
class Alternatives {
 public:
  Alternatives(const Observations& o, const std::vector<Observation>& seen, const std::vector<std::size_t>& explained,
               const Track& track)
      : o_(o), explained_(explained), impacts_{{}, {}, seen} {
    for (const TrackImpact& impact : track.impacts) {
      impacts_.candidate.push_back(impact.candidate);
      impacts_.number.push_back(impact.impact);
    }
    std::optional<Hypothesis> h = begun(0, 1);
    for (std::size_t n = 1; n < impacts_.size() && h; ++n) {
      if (n > 1) h = extended(*h, n - 1, n, -INFINITY);
      if (h) up_to_.push_back(*h);
    }
  }

  bool is_whole() const { return up_to_.size() + 1 == impacts_.size(); }

  /// Ended before impact n, which is at least the third.
  double ended_before(std::size_t n) const { return log_odds(n - 1) - log_odds(impacts_.size() - 1); }

  /// Begun at impact n, at least two before the last.
  double begun_at(std::size_t n) const { return followed(begun(n, n + 1), n + 1, kBegins); }

  double without(std::size_t n) const {
    const std::size_t next = n + 1;
    if (n == 1) return impacts_.n_missing(0, 2) == 1 ? followed(begun(0, next), next, kFollowed) : -INFINITY;
    if (impacts_.n_missing(n - 1, next) > kMostMissing) return -INFINITY;
    return followed(extended(hypothesis(n - 1), n - 1, next, least(next)), next, kFollowed);
  }

  /// Sum of the weights with other candidates in the place of n.
  double in_place_of(std::size_t n) const {
    const std::vector<Candidate>& c = o_.candidates();
    const std::size_t here = impacts_.candidate[n];
    double sum = 0.0;
    const auto take = [&](std::size_t k) {
      // what is so near is the same sound, noticed twice
      if (std::abs(c[k].t_s - c[here].t_s) > std::max(c[k].reach_s, c[here].reach_s)) sum += weight(replaced(n, k));
    };
    const bool is_last = n + 1 == impacts_.size();
    const double first_s = n > 0 ? c[impacts_.candidate[n - 1]].t_s : c[here].t_s - furthest_s(0);
    const double last_s = is_last ? c[here].t_s + furthest_s(n - 1) : c[impacts_.candidate[n + 1]].t_s;
    for (std::size_t k = here; k-- > 0 && c[k].t_s > first_s;) take(k);
    for (std::size_t k = here + 1; k < c.size() && c[k].t_s < last_s; ++k) take(k);
    return sum;
  }

 private:
  const Hypothesis& hypothesis(std::size_t n) const { return up_to_[n - 1]; }
  double log_odds(std::size_t n) const { return n > 0 ? hypothesis(n).log_odds : 0.0; }
  /// Log odds below which a hypothesis that has reached impact n is of no interest.
  double least(std::size_t n) const { return log_odds(n) + kNegligible; }

  /// The flight after impact n; beyond the first and the last none is longer.
  double furthest_s(std::size_t n) const {
    const double flight_s = impacts_.seen[n + 1].t_s - impacts_.seen[n].t_s;
    return n == 0 ? std::min(kLongestFlight_s, flight_s / kLeastEps) - flight_s : flight_s;
  }

  Hypothesis begun(std::size_t first, std::size_t second) const {
    return Hypothesis::begin(impacts_.seen[first], impacts_.seen[second], same_source(first, second), false,
                             o_.model());
  }
  double same_source(std::size_t j, std::size_t k) const {
    return o_.same_source(impacts_.candidate[j], impacts_.candidate[k]);
  }
  std::optional<Hypothesis> extended(const Hypothesis& h, std::size_t from, std::size_t to, double least) const {
    return h.extended_as_ball(impacts_.seen[to], impacts_.n_missing(from, to), same_source(from, to), least,
                              o_.model());
  }

  /// Log weight of a hypothesis that has reached impact n, over as many more of the track's.
  double followed(std::optional<Hypothesis> h, std::size_t n, std::size_t n_more) const {
    for (const std::size_t last = std::min(impacts_.size() - 1, n + n_more); h && n < last; ++n)
      h = extended(*h, n, n + 1, -INFINITY);
    return h ? h->log_odds - log_odds(n) : -INFINITY;
  }

  /// Log weight with candidate k in the place of n.
  double replaced(std::size_t n, std::size_t k) const {
    const TrackingModel& model = o_.model();
    const bool is_last = n + 1 == impacts_.size();
    const auto source = [&](std::size_t own) { return o_.same_source(impacts_.candidate[own], k); };
    std::optional<Hypothesis> h;
    if (n == 0) {
      h = Hypothesis::begin(o_.without(k, explained_), impacts_.seen[1], source(1), false, model);
      return followed(h, 1, kFollowed);
    }
    if (n == 1) {
      h = Hypothesis::begin(impacts_.seen[0], o_.without(k, explained_), source(0), false, model);
    } else {
      const int n_missing = impacts_.n_missing(n - 1, n);
      // whether it is worth the count of its neighbours without the track's own
      if (!hypothesis(n - 1).extended_as_ball(o_[k], n_missing, source(n - 1), least(n) - kOwnSounds, model))
        return -INFINITY;
      h = hypothesis(n - 1).extended_as_ball(o_.without(k, explained_), n_missing, source(n - 1), least(n), model);
    }
    if (!h || is_last) return h ? h->log_odds - log_odds(n) : -INFINITY;
    h = h->extended_as_ball(impacts_.seen[n + 1], impacts_.n_missing(n, n + 1), source(n + 1), -INFINITY, model);
    return followed(h, n + 1, kFollowed - 1);
  }

  const Observations& o_;
  const std::vector<std::size_t>& explained_;
  Impacts impacts_;
  std::vector<Hypothesis> up_to_;  ///< from the second impact on
};

}  // namespace

void set_impact_probabilities(const Observations& o, const std::vector<Observation>& seen,
                              const std::vector<std::size_t>& explained, Track& track) {
  const Alternatives alternatives(o, seen, explained, track);
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

double probability_of_inferred(double llr, double n_places) { return 1.0 / (1.0 + n_places * exp(-llr) + kOtherSound); }

bool is_at_candidate(const std::vector<Candidate>& c, double t_s) {
  constexpr double kNear_s = 3e-3;  // a template's time and that of a rise
  constexpr double kFar_s = 48e-3;  // the longest window
  auto k = std::partition_point(c.begin(), c.end(), [&](const Candidate& other) { return other.t_s < t_s - kFar_s; });
  for (; k != c.end() && k->t_s < t_s + kFar_s; ++k)
    if (std::abs(k->t_s - t_s) < std::max(kNear_s, k->reach_s)) return true;
  return false;
}

double probability_of_mark(double log_odds, double of_impact) {
  constexpr double kDecimals = 1e6;
  return std::round(kDecimals * of_impact / (1.0 + exp(-log_odds))) / kDecimals;
}

}  // namespace bouncelab::detection
