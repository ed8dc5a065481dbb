// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"
#include "tracking/drop_rate.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/impact_odds.hpp"
#include "tracking/observations.hpp"
#include "tracking/rescoring.hpp"

namespace bouncelab::detection {
namespace {

// limits of the search: what they leave out is no more probable than what is kept but by so much
constexpr std::size_t kBeam = 8;       // hypotheses that end at one candidate
constexpr double kBeamDepth = 10.0;    // log odds below the best of them
constexpr double kHopeless = -7.0;     // log odds below which a hypothesis is not followed
constexpr double kMostOfSecond = 2.0;  // log odds that the second impact adds at most
// log odds that a track may have lost because its own sounds, those to come above all, were counted as clutter
constexpr double kOwnClutter = 5.0;
constexpr double kAcceptance = 0.0;             // log odds of a track
constexpr std::size_t kStatesAtOnce = 1 << 12;  // 1 MB, which stays in the cache; then those no track needs are dropped

struct State {
  Hypothesis track;
  double start_score = 0.0;    // of the recording before this track
  std::int64_t previous = -1;  // state; -1 at the second impact of a track
  std::size_t candidate = 0;   // the last
  std::size_t first_candidate = 0;
  double largest_gain = 0.0;  // that an impact may add, but for its rise
};

/// A state before its hypothesis is made, which takes longer than to see what it would be worth.
struct Proposal {
  BallHypothesis::Step step;
  double start_score = 0.0;
  std::int64_t previous = -1;
  std::size_t first_candidate = 0;

  double total() const { return start_score + step.log_odds; }
};

/// The most probable of the states that end at one candidate.
class Beam {
 public:
  /// @param total  of the recording without a track that ends here
  void begin(double total) {
    least_total_ = total - kBeamDepth;
    proposals_.clear();
  }

  /// What is not more probable would not be kept.
  double least_total() const { return least_total_; }

  void keep(const Proposal& p) {
    if (p.step.log_odds < kHopeless || p.total() < least_total_) return;
    least_total_ = std::max(least_total_, p.total() - kBeamDepth);
    proposals_.push_back(p);
    if (proposals_.size() >= 2 * kBeam) narrow();
  }

  /// By falling flight.
  const std::vector<Proposal>& finish() {
    if (proposals_.size() > kBeam) narrow();
    std::erase_if(proposals_, [&](const Proposal& p) { return p.total() < least_total_; });
    std::sort(proposals_.begin(), proposals_.end(),
              [](const Proposal& a, const Proposal& b) { return a.step.flight_s > b.step.flight_s; });
    return proposals_;
  }

 private:
  void narrow() {
    const auto last = proposals_.begin() + (kBeam - 1);
    std::nth_element(proposals_.begin(), last, proposals_.end(),
                     [](const Proposal& a, const Proposal& b) { return a.total() > b.total(); });
    least_total_ = std::max(least_total_, last->total());
    proposals_.erase(last + 1, proposals_.end());
  }

  double least_total_ = 0.0;
  std::vector<Proposal> proposals_;
};

/// Weights of one source of a candidate and those before it, taken at once when the first is asked for: many candidates
/// need none.
class Weights {
 public:
  explicit Weights(const Observations& observations) : o_(observations) {}

  /// @param first  candidate; those before are few and taken one by one
  void begin(std::size_t k, std::size_t first) {
    constexpr std::size_t kFloats = 16;  // of a register: a row that fills them is the fastest
    k_ = k;
    first_ = first - std::min(first, (kFloats - (k - first) % kFloats) % kFloats);
    row_.clear();
  }
  double of(std::size_t j) {
    if (j < first_) return o_.same_source(j, k_);
    if (row_.empty()) {
      row_.resize(k_ - first_);
      o_.same_source(k_, first_, row_);
    }
    return row_[j - first_];
  }

 private:
  const Observations& o_;
  std::size_t k_ = 0, first_ = 0;
  std::vector<float> row_;
};

class Search {
 public:
  explicit Search(const Observations& observations)
      : o_(observations),
        weights_(o_),
        reached_s_(o_.size(), -INFINITY),
        begin_(o_.size() + 1, 0),
        best_(o_.size() + 1) {
    for (std::size_t k = 0; k < o_.size(); ++k) {
      t_s_.push_back(o_[k].t_s);
      log_odds_of_first_.push_back(log_odds_of_first(o_[k]));
    }
    for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing)
      gain_of_missing_[n_missing] = BallHypothesis::log_factor_of_missing(n_missing);
  }

  std::vector<Track> run() {
    for (std::size_t k = 0; k < o_.size(); ++k) visit(k);
    return trace();
  }

 private:
  struct Best {
    double score = 0.0;
    std::int64_t state = -1;  // the completed track that ends here or before
    bool is_ball = false;     // rather than a rhythm
  };

  void visit(std::size_t k) {
    beam_.begin(best_[k].score);
    while (t_s_[k] - t_s_[first_near_] > kLongestFlight_s) ++first_near_;
    weights_.begin(k, first_near_);
    for (std::size_t j = k; j-- > first_near_;) {
      if (t_s_[k] <= reached_s_[j]) extend_all(j, k);
      if (t_s_[k] - t_s_[j] >= kShortestFirstFlight_s) start(j, k);
    }
    std::erase_if(far_reaching_, [&](std::size_t j) { return reached_s_[j] < t_s_[k]; });
    for (auto j = far_reaching_.rbegin(); j != far_reaching_.rend(); ++j)
      if (*j < first_near_) extend_all(*j, k);
    finish(k);
  }

  void extend_all(std::size_t j, std::size_t k) {
    const double gap_s = t_s_[k] - t_s_[j];
    // states are ordered by falling flight: those that reach from j to k lie side by side
    const auto begin = states_.begin() + static_cast<std::ptrdiff_t>(begin_[j]);
    const auto end = states_.begin() + static_cast<std::ptrdiff_t>(begin_[j + 1]);
    const auto first =
        std::partition_point(begin, end, [&](const State& s) { return s.track.flight_s * kLeastEps > gap_s; });
    for (auto s = first; s != end && s->track.flight_s * kMostGap >= gap_s; ++s) extend(s - states_.begin(), k);
  }

  void finish(std::size_t k) {
    best_[k + 1] = best_[k];
    for (const Proposal& p : beam_.finish()) {
      states_.push_back(state_of(p, k));
      const State& s = states_.back();
      if (s.track.n_impacts < kFewestImpacts) continue;
      const double ball = s.track.log_odds_of_losing_ball();
      const double most = std::max(ball, s.track.log_odds_of_rhythm());
      // of the track, or none: what is improbable yet may be a track when its own sounds are no longer its clutter
      if (most + kOwnClutter <= 0.0) continue;
      constexpr double kMostOfSum = 0.7;  // of a sum over the larger one, log 2
      if (s.start_score + std::max(0.0, most) + kMostOfSum < best_[k + 1].score) continue;
      const double score = s.start_score + log_of_sum(0.0, most);
      if (score > best_[k + 1].score)
        best_[k + 1] = {score, static_cast<std::int64_t>(states_.size() - 1), most == ball};
    }
    begin_[k + 1] = states_.size();
    if (begin_[k] < begin_[k + 1]) {
      const double reach_s = states_[begin_[k]].track.flight_s * kMostGap;
      reached_s_[k] = t_s_[k] + reach_s;
      if (reach_s > kLongestFlight_s) far_reaching_.push_back(k);
    }
    if (states_.size() > most_states_) forget(k + 1);
  }

  State state_of(const Proposal& p, std::size_t k) const {
    State state{{}, p.start_score, p.previous, k, p.first_candidate, 0.0};
    if (p.previous < 0) {
      state.track = Hypothesis(o_[p.first_candidate], o_[k], p.step);
    } else {
      state.track = states_[static_cast<std::size_t>(p.previous)].track;
      state.track.take(p.step, o_[k]);
    }
    state.largest_gain = state.track.largest_gain();
    return state;
  }

  /// Keeps the states from which tracks may yet be followed, and those on the way to them.
  void forget(std::size_t n_visited) {
    std::size_t live = n_visited;
    while (live > 0 && o_[n_visited - 1].t_s - o_[live - 1].t_s <= kMostGap * kLongestFlight_s) --live;
    std::vector<std::int64_t> index(states_.size(), -1);  // from here on: 0 where needed, then the new place
    const auto need = [&](std::int64_t s) {
      if (s >= 0) index[static_cast<std::size_t>(s)] = 0;
    };
    for (std::size_t s = begin_[live]; s < states_.size(); ++s) need(static_cast<std::int64_t>(s));
    for (std::size_t k = live; k <= n_visited; ++k) need(best_[k].state);
    for (std::size_t s = states_.size(); s-- > 0;)
      if (index[s] == 0) need(states_[s].previous >= 0 ? states_[s].previous : best_[states_[s].first_candidate].state);
    std::size_t n_kept = 0;
    std::vector<std::size_t> n_before(states_.size() + 1, 0);
    for (std::size_t s = 0; s < states_.size(); ++s) {
      n_before[s + 1] = n_kept;
      if (index[s] < 0) continue;
      index[s] = static_cast<std::int64_t>(n_kept);
      State kept = states_[s];
      if (kept.previous >= 0) kept.previous = index[static_cast<std::size_t>(kept.previous)];
      states_[n_kept++] = kept;
      n_before[s + 1] = n_kept;
    }
    states_.resize(n_kept);
    for (std::size_t k = 0; k <= n_visited; ++k) {
      begin_[k] = n_before[begin_[k]];
      if (best_[k].state >= 0) best_[k].state = index[static_cast<std::size_t>(best_[k].state)];
    }
    most_states_ = 2 * n_kept + kStatesAtOnce;
  }

  void start(std::size_t j, std::size_t k) {
    const double most = log_odds_of_first_[j] + o_[k].log_rise_odds + kMostOfSecond;
    const double least_log_odds = std::max(kHopeless, beam_.least_total() - best_[j].score);
    if (most < least_log_odds || most <= kHopeless) return;
    const auto begun = [&](double weight) {
      return BallHypothesis::first_step(least_log_odds, {log_odds_of_first_[j], log_usual_eps_}, o_[j], o_[k], weight,
                                        true);
    };
    if (!begun(1.0)) return;  // most are improbable whatever their source
    if (const std::optional<BallHypothesis::Step> step = begun(weights_.of(j)))
      beam_.keep({*step, best_[j].score, -1, j});
  }

  void extend(std::int64_t from_index, std::size_t k) {
    const State& from = states_[static_cast<std::size_t>(from_index)];
    const int most_missing = from.track.n_eps() == 0 ? 0 : kMostMissing;  // two sounds alone predict nothing
    const double gap = (t_s_[k] - t_s_[from.candidate]) / from.track.flight_s;
    for (int n_missing = 0; n_missing <= most_missing; ++n_missing) {
      if (!may_be_gap(gap, n_missing)) continue;
      const double least_log_odds = std::max(kHopeless, beam_.least_total() - from.start_score);
      const double most = from.track.log_odds + o_[k].log_rise_odds + from.largest_gain + gain_of_missing_[n_missing];
      if (most < least_log_odds) continue;
      if (const std::optional<BallHypothesis::Step> step =
              from.track.step_to(o_[k], n_missing, weights_.of(from.candidate), true, least_log_odds))
        beam_.keep({*step, from.start_score, from_index, from.first_candidate});
    }
  }

  std::vector<Track> trace() const {
    std::vector<Track> tracks;
    for (Best end = best_[o_.size()]; end.state >= 0;) {
      Track track;
      const State* s = &states_[static_cast<std::size_t>(end.state)];
      for (;; s = &states_[static_cast<std::size_t>(s->previous)]) {
        track.impacts.push_back({s->candidate, s->track.impact});
        if (s->previous < 0) break;
      }
      track.impacts.push_back({s->first_candidate, 0});
      std::reverse(track.impacts.begin(), track.impacts.end());
      if (end.is_ball) tracks.push_back(std::move(track));
      end = best_[s->first_candidate];
    }
    std::reverse(tracks.begin(), tracks.end());
    return tracks;
  }

  const Observations& o_;
  Weights weights_;
  Beam beam_;
  double log_usual_eps_ = log(kTracking.usual_eps);
  std::array<double, kMostMissing + 1> gain_of_missing_{};  // at most
  std::size_t first_near_ = 0;                              // candidate within the longest flight
  std::vector<double> t_s_;                                 // of the candidates
  std::vector<double> reached_s_;                           // until when a state of each may go on
  std::vector<std::size_t> far_reaching_;  // candidates of which one may for longer than the longest flight
  std::vector<double> log_odds_of_first_;  // of a track that begins with each candidate
  std::vector<State> states_;
  std::vector<std::size_t> begin_;  // states of candidate k: begin_[k] ... begin_[k+1]
  std::vector<Best> best_;          // best_[k]: over candidates before k
  std::size_t most_states_ = kStatesAtOnce;
};

}  // namespace

std::optional<double> eps_at(const std::vector<Candidate>& c, const Track& track, std::size_t k) {
  const std::vector<TrackImpact>& impacts = track.impacts;
  if (k == 0 || k + 1 >= impacts.size() || impacts[k + 1].impact - impacts[k - 1].impact != 2) return {};
  const double t_s = c[impacts[k].candidate].t_s;
  return (c[impacts[k + 1].candidate].t_s - t_s) / (t_s - c[impacts[k - 1].candidate].t_s);
}

std::vector<Track> find_tracks(const std::vector<Candidate>& candidates, double timing_s, const SameSource& same_source,
                               double duration_s) {
  const Observations observations(candidates, timing_s, same_source, duration_s);
  auto [tracks, own] = rescored(observations, Search(observations).run());
  weigh_by_drop_rate(candidates, tracks);
  std::vector<Track> accepted;
  for (std::size_t k = 0; k < tracks.size(); ++k) {
    if (tracks[k].log_odds < kAcceptance) continue;
    set_impact_probabilities(observations, own[k], tracks[k]);
    accepted.push_back(std::move(tracks[k]));
  }
  return accepted;
}

}  // namespace bouncelab::detection
