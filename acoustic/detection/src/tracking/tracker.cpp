// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tracking/bounce_model.hpp"
#include "tracking/observations.hpp"
#include "tracking/rescoring.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kBeam = 8;
constexpr double kBeamDepth = 10.0;
constexpr std::size_t kStatesAtOnce =
    1 << 12;                        // 1 MB, which stays in the cache; then those no train needs are forgotten
constexpr double kHopeless = -5.5;  // log odds below which a young train is not followed
// log odds that a train may have lost because its own sounds, those to come above all, were counted as rivals
constexpr double kOwnRivals = 5.0;
constexpr std::int64_t kLeastImpacts = 3;
constexpr double kMostStart = 2.0;  // of the second impact
constexpr double kMostGain = 11.0;  // of one impact: density 20 to 200 at the best place, amplitude in favour

struct State : TrainState {
  double start_score = 0.0;    // of the recording before this train
  std::int64_t previous = -1;  // state; -1 at the second impact of a train
  std::size_t candidate = 0;   // the last
  std::size_t first_candidate = 0;

  double total() const { return start_score + log_odds; }
};

/// The most probable of the states that end at one candidate.
class Beam {
 public:
  /// @param total  of the recording without a train that ends here
  explicit Beam(double total) : least_total_(total - kBeamDepth) {}

  /// What is not more probable would not be kept.
  double least_total() const { return least_total_; }

  void keep(const State& s) {
    if (s.log_odds < kHopeless || s.total() < least_total_) return;
    least_total_ = std::max(least_total_, s.total() - kBeamDepth);
    states_.push_back(s);
    if (states_.size() >= 2 * kBeam) narrow();
  }

  /// By falling flight.
  const std::vector<State>& finish() {
    if (states_.size() > kBeam) narrow();
    std::erase_if(states_, [&](const State& s) { return s.total() < least_total_; });
    std::sort(states_.begin(), states_.end(), [](const State& a, const State& b) { return a.flight_s > b.flight_s; });
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

class Search {
 public:
  Search(const std::vector<Candidate>& candidates, double timing_s, const std::vector<BandEnergies>& band_energies)
      : c_(candidates), sounds_(candidates, timing_s, band_energies), begin_(c_.size() + 1, 0), best_(c_.size() + 1) {}

  std::vector<Train> run() {
    for (std::size_t k = 0; k < c_.size(); ++k) visit(k);
    return trace();
  }

 private:
  struct Best {
    double score = 0.0;
    std::int64_t state = -1;  // the completed train that ends here or before
    std::int64_t n_of_ball = 0;
  };

  void visit(std::size_t k) {
    Beam here(best_[k].score);
    HeardSound next = sounds_.heard(k);
    for (std::size_t j = k; j-- > 0;) {
      const double gap_s = c_[k].t_s - c_[j].t_s;
      if (gap_s > kMostGap * kLongestFlight_s) break;
      // states are ordered by falling flight: those that reach from j to k lie side by side
      const auto begin = states_.begin() + static_cast<std::ptrdiff_t>(begin_[j]);
      const auto end = states_.begin() + static_cast<std::ptrdiff_t>(begin_[j + 1]);
      const auto first =
          std::partition_point(begin, end, [&](const State& s) { return s.flight_s * kLeastEps > gap_s; });
      const bool may_start = gap_s >= kShortestFirstFlight_s && gap_s <= kLongestFlight_s &&
                             sounds_.log_odds_first[j] > kHopeless - kMostStart;
      if (may_start || (first != end && first->flight_s * kMostGap >= gap_s)) next.alike = sounds_.alike(j, k);
      for (auto s = first; s != end && s->flight_s * kMostGap >= gap_s; ++s) extend(s - states_.begin(), k, next, here);
      if (may_start) start(j, k, next, here);
    }
    best_[k + 1] = best_[k];
    for (const State& s : here.finish()) {
      if (s.n_heard >= kLeastImpacts) {
        const double ball = s.log_odds_of_ball() + kOwnRivals;
        const std::size_t r = s.log_odds_rhythm[1] > s.log_odds_rhythm[0] ? 1 : 0;
        const double rhythm = s.log_odds_rhythm[r] + kOwnRivals + 1.0;
        const std::size_t q = s.log_odds_ball_then_rhythm[1] > s.log_odds_ball_then_rhythm[0] ? 1 : 0;
        const double both = s.log_odds_ball_then_rhythm[q] + kOwnRivals;
        const double most = std::max({ball, rhythm, both});
        if (most > kAcceptance && s.start_score + most > best_[k + 1].score)
          best_[k + 1] = {s.start_score + most, static_cast<std::int64_t>(states_.size()),
                          most == ball     ? s.n_heard
                          : most == rhythm ? 0
                                           : s.n_of_ball[q]};
      }
      states_.push_back(s);
    }
    begin_[k + 1] = states_.size();
    if (states_.size() > most_states_) forget(k + 1);
  }

  /// Keeps the states from which trains may yet be followed, and those on the way to them.
  void forget(std::size_t n_visited) {
    std::size_t live = n_visited;
    while (live > 0 && c_[n_visited - 1].t_s - c_[live - 1].t_s <= kMostGap * kLongestFlight_s) --live;
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

  void start(std::size_t j, std::size_t k, const HeardSound& second, Beam& here) const {
    State s;
    static_cast<TrainState&>(s) = begin_train(sounds_.heard(j), second);
    s.start_score = best_[j].score;
    s.candidate = k;
    s.first_candidate = j;
    here.keep(s);
  }

  void extend(std::int64_t from_index, std::size_t k, const HeardSound& next, Beam& here) const {
    const State& from = states_[static_cast<std::size_t>(from_index)];
    if (from.total() + kMostGain < here.least_total()) return;
    const int most_missing = from.n_eps == 0 ? 0 : kMostMissing;  // two sounds alone predict nothing
    for (int n_missing = 0; n_missing <= most_missing; ++n_missing) {
      const double least_log_odds = std::max(kHopeless, here.least_total() - from.start_score);
      const std::optional<TrainState> longer = extend_train(from, n_missing, next, least_log_odds);
      if (!longer) continue;
      State s = from;
      static_cast<TrainState&>(s) = *longer;
      s.candidate = k;
      s.previous = from_index;
      here.keep(s);
    }
  }

  std::vector<Train> trace() const {
    std::vector<Train> trains;
    Best end = best_[c_.size()];
    for (std::int64_t at = end.state; at >= 0;) {
      Train train;
      const State* s = &states_[static_cast<std::size_t>(at)];
      train.log_odds = s->log_odds_of_ball();
      for (;; s = &states_[static_cast<std::size_t>(s->previous)]) {
        train.impacts.push_back({s->candidate, s->impact});
        if (s->previous < 0) break;
      }
      train.impacts.push_back({s->first_candidate, 0});
      std::reverse(train.impacts.begin(), train.impacts.end());
      const std::int64_t n_of_ball = end.n_of_ball;
      end = best_[s->first_candidate];
      at = end.state;
      if (n_of_ball < kLeastImpacts) continue;
      train.impacts.resize(static_cast<std::size_t>(n_of_ball));
      trains.push_back(std::move(train));
    }
    std::reverse(trains.begin(), trains.end());
    review_trains(sounds_, trains);
    return trains;
  }

  const std::vector<Candidate>& c_;
  HeardSounds sounds_;
  std::vector<State> states_;
  std::vector<std::size_t> begin_;  // states of candidate k: begin_[k] ... begin_[k+1]
  std::vector<Best> best_;          // best_[k]: over candidates before k
  std::size_t most_states_ = kStatesAtOnce;
};

}  // namespace

std::vector<Train> find_trains(const std::vector<Candidate>& candidates, double timing_s,
                               const std::vector<BandEnergies>& band_energies) {
  return Search(candidates, timing_s, band_energies).run();
}

}  // namespace bouncelab::detection
