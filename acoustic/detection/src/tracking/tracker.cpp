// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "tracking/hypothesis.hpp"
#include "tracking/observations.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
namespace {

// limits of the search: what they leave out is no more probable than what is kept but by so much
struct Width {
  std::size_t n_states = 8;  // that end at one candidate
  double depth = 8.0;        // log odds below the best of them
};
constexpr Width kOfAll{8, 8.0};
constexpr Width kOfBalls{4, 7.0};      // without rhythms far more states are followed; what is found is searched again
constexpr double kHopeless = -8.0;     // log odds below which a hypothesis is not followed
constexpr double kMostOfSecond = 2.0;  // log odds that the second impact adds at most
// log odds that a track may have lost because its own sounds, those to come above all, were counted as clutter
constexpr double kOwnClutter = 5.0;
constexpr double kAcceptance = 0.0;         // log odds of a track
constexpr double kMostCorrelation = 0.999;  // copies of one sound, as generators make them, are no surer balls

struct State {
  Hypothesis track;
  double start_score = 0.0;  // of the recording before this track
  std::size_t first_candidate = 0, candidate = 0;
  std::int64_t impact = 0;  // the last, among all that any state has or had
};

/// A state before its hypothesis is made, which takes longer than to see what it would be worth.
struct Proposal {
  Hypothesis::Step step;
  double start_score = 0.0;
  std::size_t first_candidate = 0;
  const State* previous = nullptr;  // none at the second impact of a track

  double total() const { return start_score + step.log_odds; }
};

/// The most probable of the states that end at one candidate.
class Beam {
 public:
  explicit Beam(const Width& width) : width_(width) {}

  /// @param total  of the recording without a track that ends here
  void begin(double total) {
    least_total_ = total - width_.depth;
    proposals_.clear();
  }

  /// What is not more probable would not be kept.
  double least_total() const { return least_total_; }

  void keep(const Proposal& p) {
    if (p.step.log_odds < kHopeless || p.total() < least_total_) return;
    least_total_ = std::max(least_total_, p.total() - width_.depth);
    proposals_.push_back(p);
    if (proposals_.size() >= 2 * width_.n_states) narrow();
  }

  /// By falling flight.
  const std::vector<Proposal>& finish() {
    if (proposals_.size() > width_.n_states) narrow();
    std::erase_if(proposals_, [&](const Proposal& p) { return p.total() < least_total_; });
    std::sort(proposals_.begin(), proposals_.end(),
              [](const Proposal& a, const Proposal& b) { return a.step.flight_s > b.step.flight_s; });
    return proposals_;
  }

 private:
  void narrow() {
    const auto last = proposals_.begin() + static_cast<std::ptrdiff_t>(width_.n_states - 1);
    std::nth_element(proposals_.begin(), last, proposals_.end(),
                     [](const Proposal& a, const Proposal& b) { return a.total() > b.total(); });
    least_total_ = std::max(least_total_, last->total());
    proposals_.erase(last + 1, proposals_.end());
  }

  Width width_;
  double least_total_ = 0.0;
  std::vector<Proposal> proposals_;
};

class Search {
 public:
  /// @param offered       observations of the recording, rising; of `observations` or with others explained
  /// @param candidates    of each of them; none = all of the recording
  /// @param with_rhythms  which compete with balls
  Search(const Observations& observations, std::span<const Observation> offered, std::vector<std::size_t> candidates,
         bool with_rhythms)
      : same_source_(observations),
        o_(offered),
        candidates_(std::move(candidates)),
        with_rhythms_(with_rhythms),
        beam_(with_rhythms ? kOfAll : kOfBalls),
        reached_s_(o_.size(), -INFINITY),
        states_(o_.size()),
        best_(o_.size() + 1) {}

  std::vector<Track> run() {
    for (std::size_t k = 0; k < o_.size(); ++k) visit(k);
    return trace();
  }

 private:
  struct Best {
    double score = 0.0;
    std::int64_t impact = -1;  // the last of the completed track that ends here or before
    bool is_ball = false;      // rather than a rhythm
  };
  struct Impact {
    TrackImpact impact;
    std::int64_t previous = -1;  // of its track
  };

  void visit(std::size_t k) {
    beam_.begin(best_[k].score);
    for (; o_[k].t_s - o_[oldest_].t_s > kLongestFlight_s && reached_s_[oldest_] < o_[k].t_s; ++oldest_)
      states_[oldest_] = {};
    for (std::size_t j = k; j-- > oldest_;) {
      if (o_[k].t_s <= reached_s_[j])
        for (const State& state : states_[j]) extend(state, k);
      const double flight_s = o_[k].t_s - o_[j].t_s;
      if (flight_s >= kShortestFirstFlight_s && flight_s <= kLongestFlight_s) start(j, k);
    }
    finish(k);
  }

  void start(std::size_t j, std::size_t k) {
    const double least_log_odds = std::max(kHopeless, beam_.least_total() - best_[j].score);
    const double most = o_[j].log_odds_of_first + o_[k].log_rise_odds + kMostOfSecond;
    if (most < least_log_odds || most <= kHopeless) return;
    const auto step_of = [&](double same_source) {
      return Hypothesis::first_step(o_[j], o_[k], same_source, true, least_log_odds);
    };
    if (const auto step = step_from(j, k, step_of)) beam_.keep({*step, best_[j].score, j, nullptr});
  }

  void extend(const State& from, std::size_t k) {
    const int most_missing = from.track.n_impacts == 2 ? 0 : kMostMissing;  // two sounds alone predict nothing
    for (int n_missing = 0; n_missing <= most_missing; ++n_missing) {
      const double least_log_odds = std::max(kHopeless, beam_.least_total() - from.start_score);
      const auto step_of = [&](double same_source) {
        return from.track.step_to(o_[k], n_missing, same_source, true, least_log_odds);
      };
      if (const auto step = step_from(from.candidate, k, step_of))
        beam_.keep({*step, from.start_score, from.first_candidate, &from});
    }
  }

  /// Most steps are improbable whatever their sounds' source, which takes longer to compare.
  template <class StepOf>
  std::optional<Hypothesis::Step> step_from(std::size_t j, std::size_t k, const StepOf& step_of) const {
    return step_of(1.0) ? step_of(same_source_.same_source(candidate(j), candidate(k))) : std::nullopt;
  }

  void finish(std::size_t k) {
    best_[k + 1] = best_[k];
    for (const Proposal& p : beam_.finish()) {
      const State& s = states_[k].emplace_back(state_of(p, k));
      if (s.track.n_impacts < kFewestImpacts) continue;
      const double ball = s.track.log_odds_of_losing_ball();
      const double most = with_rhythms_ ? std::max(ball, s.track.log_odds_of_rhythm()) : ball;
      // of the track, or none: what is improbable yet may be a track when its own sounds are no longer its clutter
      if (most + kOwnClutter <= 0.0) continue;
      const double score = s.start_score + log_of_sum(0.0, most);
      if (score > best_[k + 1].score) best_[k + 1] = {score, s.impact, most == ball};
    }
    if (!states_[k].empty()) reached_s_[k] = o_[k].t_s + states_[k].front().track.flight_s * kMostGap;
  }

  State state_of(const Proposal& p, std::size_t k) {
    if (p.previous == nullptr) {
      impacts_.push_back({{p.first_candidate, 0}, -1});
      impacts_.push_back({{k, 1}, std::ssize(impacts_) - 1});
      return {Hypothesis(o_[p.first_candidate], o_[k], p.step), p.start_score, p.first_candidate, k,
              std::ssize(impacts_) - 1};
    }
    State state = *p.previous;
    state.track.take(p.step, o_[k]);
    state.candidate = k;
    impacts_.push_back({{k, state.track.impact}, state.impact});
    state.impact = std::ssize(impacts_) - 1;
    return state;
  }

  std::vector<Track> trace() const {
    std::vector<Track> tracks;
    for (Best end = best_.back(); end.impact >= 0;) {
      Track track;
      for (std::int64_t k = end.impact; k >= 0; k = impacts_[static_cast<std::size_t>(k)].previous)
        track.impacts.push_back(impacts_[static_cast<std::size_t>(k)].impact);
      std::reverse(track.impacts.begin(), track.impacts.end());
      const std::size_t first = track.impacts.front().candidate;
      for (TrackImpact& impact : track.impacts) impact.candidate = candidate(impact.candidate);
      if (end.is_ball) tracks.push_back(std::move(track));
      end = best_[first];
    }
    std::reverse(tracks.begin(), tracks.end());
    return tracks;
  }

  std::size_t candidate(std::size_t k) const { return candidates_.empty() ? k : candidates_[k]; }

  const Observations& same_source_;
  std::span<const Observation> o_;
  std::vector<std::size_t> candidates_;
  bool with_rhythms_;
  Beam beam_;
  std::size_t oldest_ = 0;                  // candidate from which a track may go on
  std::vector<double> reached_s_;           // until when a state of each candidate may go on
  std::vector<std::vector<State>> states_;  // that end at each candidate, by falling flight; the old ones are dropped
  std::vector<Impact> impacts_;
  std::vector<Best> best_;  // best_[k]: over candidates before k
};

}  // namespace

std::optional<double> eps_at(const std::vector<Candidate>& c, const Track& track, std::size_t k) {
  const std::vector<TrackImpact>& impacts = track.impacts;
  if (k == 0 || k + 1 >= impacts.size() || impacts[k + 1].impact - impacts[k - 1].impact != 2) return {};
  const double t_s = c[impacts[k].candidate].t_s;
  return (c[impacts[k + 1].candidate].t_s - t_s) / (t_s - c[impacts[k - 1].candidate].t_s);
}

std::vector<Track> find_balls(const Observations& o, const std::vector<std::size_t>& taken,
                              const std::vector<std::size_t>& explained, double begin_s, double end_s) {
  if (explained.empty() && begin_s == -HUGE_VAL) return Search(o, o.all(), {}, false).run();
  std::vector<std::size_t> left;
  std::vector<Observation> seen;
  const auto first = std::partition_point(o.all().begin(), o.all().end(),
                                          [&](const Observation& sound) { return sound.t_s < begin_s; });
  for (auto k = static_cast<std::size_t>(first - o.all().begin()); k < o.size() && o[k].t_s <= end_s; ++k)
    if (!std::binary_search(taken.begin(), taken.end(), k)) {
      left.push_back(k);
      seen.push_back(o.without(k, explained));
    }
  if (left.empty()) return {};
  return Search(o, seen, std::move(left), false).run();
}

double log_odds_of_likeness(const Track& track, const Likeness& likeness) {
  const auto n = std::min(track.impacts.size() - 1, static_cast<std::size_t>(kTracking.memory));
  double sum = 0.0;
  for (std::size_t k = 0; k < n; ++k) sum += likeness(track.impacts[k].candidate, track.impacts[k + 1].candidate);
  const double z = std::atanh(std::min(sum / static_cast<double>(n), kMostCorrelation));
  return log(student3(z - kTracking.likeness, kTracking.likeness_scatter) /
             student3(z - kTracking.other_likeness, kTracking.other_likeness_scatter));
}

std::vector<Track> find_tracks(const std::vector<Candidate>& candidates, double timing_s, const SameSource& same_source,
                               double duration_s, std::optional<double> elastic_flight_s, const Likeness& likeness) {
  const Observations observations(candidates, timing_s, same_source, duration_s, elastic_flight_s);
  std::vector<Track> tracks = rescored(observations, Search(observations, observations.all(), {}, true).run());
  add_balls_at_once(observations, tracks);
  if (likeness)
    for (Track& track : tracks) track.log_odds += log_odds_of_likeness(track, likeness);
  weigh_by_drop_rate(candidates, tracks);
  std::erase_if(tracks, [](const Track& track) { return track.log_odds < kAcceptance; });
  for (std::size_t t = 0; t < tracks.size(); ++t)
    set_impact_probabilities(observations, tracks[t], explained_by_others(observations, tracks, t));
  return tracks;
}

}  // namespace bouncelab::detection
