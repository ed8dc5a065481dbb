// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "tracking/drop_rate.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/log_sum.hpp"
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
constexpr double kOpen = 10.0;                  // beyond, no other evidence decides
constexpr std::size_t kStatesAtOnce = 1 << 12;  // 1 MB, which stays in the cache; then those no track needs are dropped

struct State {
  Hypothesis track;
  double start_score = 0.0;    // of the recording before this track
  std::int64_t previous = -1;  // state; -1 at the second impact of a track
  std::size_t candidate = 0;   // the last
  std::size_t first_candidate = 0;
  std::array<double, kMostMissing + 1> largest_gain{};  // by impacts missing before the next

  double total() const { return start_score + track.log_odds; }
};

/// The most probable of the states that end at one candidate.
class Beam {
 public:
  /// @param total  of the recording without a track that ends here
  explicit Beam(double total) : least_total_(total - kBeamDepth) {}

  /// What is not more probable would not be kept.
  double least_total() const { return least_total_; }

  void keep(const State& s) {
    if (s.track.log_odds < kHopeless || s.total() < least_total_) return;
    least_total_ = std::max(least_total_, s.total() - kBeamDepth);
    states_.push_back(s);
    if (states_.size() >= 2 * kBeam) narrow();
  }

  /// By falling flight.
  const std::vector<State>& finish() {
    if (states_.size() > kBeam) narrow();
    std::erase_if(states_, [&](const State& s) { return s.total() < least_total_; });
    std::sort(states_.begin(), states_.end(),
              [](const State& a, const State& b) { return a.track.flight_s > b.track.flight_s; });
    return states_;
  }

 private:
  void narrow() {
    const auto last = states_.begin() + (kBeam - 1);
    std::nth_element(states_.begin(), last, states_.end(),
                     [](const State& a, const State& b) { return a.total() > b.total(); });
    least_total_ = std::max(least_total_, last->total());
    states_.erase(last + 1, states_.end());
  }

  double least_total_;
  std::vector<State> states_;
};

/// That two candidates have one source; taken when it is first asked for, since most pairs need none.
class Weight {
 public:
  Weight(const Observations& observations, std::size_t j, std::size_t k) : o_(observations), j_(j), k_(k) {}
  double value() {
    if (!value_) value_ = o_.same_source(j_, k_);
    return *value_;
  }

 private:
  const Observations& o_;
  std::size_t j_, k_;
  std::optional<double> value_;
};

class Search {
 public:
  explicit Search(const Observations& observations)
      : o_(observations), reached_s_(o_.size(), -INFINITY), begin_(o_.size() + 1, 0), best_(o_.size() + 1) {
    for (std::size_t k = 0; k < o_.size(); ++k) {
      t_s_.push_back(o_[k].t_s);
      log_odds_of_first_.push_back(log_odds_of_first(o_[k], o_.model()));
    }
  }

  std::vector<Track> run() {
    for (std::size_t k = 0; k < o_.size(); ++k) visit(k);
    return trace();
  }

 private:
  struct Best {
    double score = 0.0;
    std::int64_t state = -1;  // the completed track that ends here or before
    std::int64_t n_of_ball = 0;
  };

  bool may_begin(std::size_t j, std::size_t k) const {
    const double gap_s = t_s_[k] - t_s_[j];
    return gap_s >= kShortestFirstFlight_s && log_odds_of_first_[j] + o_[k].log_rise_odds + kMostOfSecond > kHopeless;
  }

  void visit(std::size_t k) {
    Beam here(best_[k].score);
    for (std::size_t j = k; j-- > 0 && t_s_[k] - t_s_[j] <= kLongestFlight_s;) {
      Weight same_source(o_, j, k);
      if (t_s_[k] <= reached_s_[j]) extend_all(j, k, same_source, here);
      if (may_begin(j, k)) start(j, k, same_source, here);
    }
    std::erase_if(far_reaching_, [&](std::size_t j) { return reached_s_[j] < t_s_[k]; });
    for (auto j = far_reaching_.rbegin(); j != far_reaching_.rend(); ++j)
      if (t_s_[k] - t_s_[*j] > kLongestFlight_s) {
        Weight same_source(o_, *j, k);
        extend_all(*j, k, same_source, here);
      }
    finish(k, here);
  }

  void extend_all(std::size_t j, std::size_t k, Weight& same_source, Beam& here) const {
    const double gap_s = t_s_[k] - t_s_[j];
    // states are ordered by falling flight: those that reach from j to k lie side by side
    const auto begin = states_.begin() + static_cast<std::ptrdiff_t>(begin_[j]);
    const auto end = states_.begin() + static_cast<std::ptrdiff_t>(begin_[j + 1]);
    const auto first =
        std::partition_point(begin, end, [&](const State& s) { return s.track.flight_s * kLeastEps > gap_s; });
    for (auto s = first; s != end && s->track.flight_s * kMostGap >= gap_s; ++s)
      extend(s - states_.begin(), k, same_source, here);
  }

  void finish(std::size_t k, Beam& here) {
    best_[k + 1] = best_[k];
    for (const State& s : here.finish()) {
      if (s.track.n_impacts >= kFewestImpacts) {
        const Hypothesis::Verdict most = s.track.most_probable(o_.model());
        // of the track, or none: what is improbable yet may be a track when its own sounds are no longer its clutter
        const double score = s.start_score + log_of_sum(0.0, most.log_odds);
        if (most.log_odds + kOwnClutter > 0.0 && score > best_[k + 1].score)
          best_[k + 1] = {score, static_cast<std::int64_t>(states_.size()), most.n_of_ball};
      }
      states_.push_back(s);
      for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing)
        states_.back().largest_gain[n_missing] = s.track.largest_gain(n_missing, o_.model());
    }
    begin_[k + 1] = states_.size();
    if (begin_[k] < begin_[k + 1]) {
      const double reach_s = states_[begin_[k]].track.flight_s * kMostGap;
      reached_s_[k] = t_s_[k] + reach_s;
      if (reach_s > kLongestFlight_s) far_reaching_.push_back(k);
    }
    if (states_.size() > most_states_) forget(k + 1);
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

  void start(std::size_t j, std::size_t k, Weight& same_source, Beam& here) const {
    const double least_log_odds = std::max(kHopeless, here.least_total() - best_[j].score);
    const auto begun = [&](double weight) {
      return Hypothesis::begin_above(least_log_odds, {log_odds_of_first_[j], log_usual_eps_}, o_[j], o_[k], weight,
                                     true, o_.model());
    };
    if (!begun(1.0)) return;  // most are improbable whatever their source
    const std::optional<Hypothesis> track = begun(same_source.value());
    if (track) here.keep({*track, best_[j].score, -1, k, j, {}});
  }

  void extend(std::int64_t from_index, std::size_t k, Weight& same_source, Beam& here) const {
    const State& from = states_[static_cast<std::size_t>(from_index)];
    const int most_missing = from.track.n_eps() == 0 ? 0 : kMostMissing;  // two sounds alone predict nothing
    const double gap = (t_s_[k] - t_s_[from.candidate]) / from.track.flight_s;
    for (int n_missing = 0; n_missing <= most_missing; ++n_missing) {
      if (!may_be_gap(gap, n_missing)) continue;
      const double least_log_odds = std::max(kHopeless, here.least_total() - from.start_score);
      if (from.track.log_odds + o_[k].log_rise_odds + from.largest_gain[n_missing] < least_log_odds) continue;
      const std::optional<Hypothesis> longer =
          from.track.extended(o_[k], n_missing, same_source.value(), true, least_log_odds, o_.model());
      if (longer) here.keep({*longer, from.start_score, from_index, k, from.first_candidate, {}});
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
      track.impacts.resize(static_cast<std::size_t>(end.n_of_ball));  // the others are a rhythm's
      end = best_[s->first_candidate];
      if (std::ssize(track.impacts) >= kFewestImpacts) tracks.push_back(std::move(track));
    }
    std::reverse(tracks.begin(), tracks.end());
    return tracks;
  }

  const Observations& o_;
  double log_usual_eps_ = log(o_.model().usual_eps);
  std::vector<double> t_s_;                // of the candidates
  std::vector<double> reached_s_;          // until when a state of each may go on
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
                               const TrackingModel& model, const std::function<double(const Track&)>& other_evidence) {
  const Observations observations(candidates, timing_s, same_source, model);
  std::vector<Track> tracks = rescored(observations, Search(observations).run());
  if (other_evidence)
    for (Track& track : tracks)
      if (std::abs(track.log_odds) < kOpen) track.log_odds += other_evidence(track);
  weigh_by_drop_rate(candidates, tracks, model);
  std::erase_if(tracks, [](const Track& track) { return track.log_odds < kAcceptance; });
  set_impact_probabilities(observations, tracks);
  return tracks;
}

}  // namespace bouncelab::detection
