// SPDX-License-Identifier: GPL-3.0-or-later
#include "trains.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "bouncelab/core/units.hpp"

namespace bouncelab {
namespace {

constexpr double kShortestFlight_s = 1e-3;
constexpr double kLongestFlight_s = 2.5;  // a fall from 7.6 m
// a train begins with 0.2 m/s or more (a drop from 2 mm) and goes on for a while; a voice's pulses do neither
constexpr double kShortestFirstFlight_s = 40e-3;
constexpr double kShortestTrain_s = 0.4;
constexpr double kLeastOfMean = 0.7;  // single losses of 20 % are real, of 30 % not
constexpr double kMostOfMean = 1.4;
constexpr double kMostUnheard = 0.15;      // of the impacts, and one more
constexpr double kMostOutliers = 0.1;      // of the impacts, and one more
constexpr double kLeastEps = 0.4;          // a basketball on carpet has 0.5
constexpr double kLargestEps = 1.2;        // single gains of a spinning ball
constexpr double kScatter = 0.015;         // of log eps from impact to impact, before the train itself is heard
constexpr double kScatterWeight = 3.0;     // impacts that this prior is worth: 0.003 and 0.06 are both plausible
constexpr double kAmplitudeScatter = 0.4;  // of log amplitude from impact to impact: the place struck varies
constexpr double kChanceAmplitude = 1.2;   // of log amplitude from one sound to any other
constexpr double kOutlier = 0.05;          // share of single losses and gains
constexpr double kHeard = 0.93;
constexpr int kMostMissing = 2;
constexpr double kMostGap = kLargestEps * (1.0 + kLargestEps * (1.0 + kLargestEps));  // of the last flight
constexpr int kMemory = 8;                 // impacts over which eps is taken as constant
constexpr std::size_t kLeastImpacts = 5;   // three coefficients of restitution
constexpr double kLargestMeanEps = 0.997;  // a clock is no ball,
constexpr double kLeastLogLoss = 0.045;    // nor is one that jumped once,
constexpr double kLeastLosing = 0.6;       // nor one that jumped twice: most impacts lose energy
constexpr double kStartCost = 7.0;         // prior log odds against a train starting at a given pair
constexpr double kAcceptance = 8.0;        // log odds a train must reach: 1 in 3000 by chance
constexpr std::size_t kBeam = 32;
constexpr double kBeamDepth = 18.0;
constexpr std::size_t kStatesAtOnce = 1 << 17;  // 18 MB; then those no train needs are forgotten
constexpr double kHopeless = -13.0;             // log odds below which a young train is not followed
constexpr double kMostGain = 8.0;  // of one impact: density 20 to 200 at the best place, amplitude in favour
constexpr int kOctaves = 12;
constexpr double kSmallestReach_s = 2e-3;

struct State {
  double score = 0.0;     // of the whole recording up to here
  double flight_s = 0.0;  // last interval, or what it would have been
  double mean_log_eps = 0.0;
  double mean_eps = 1.0;
  double sum_squares = 0.0;  // of the deviations of log eps from its running mean, large ones cut
  double log_loss = 0.0;     // -sum of log eps, large deviations cut
  int n_outliers = 0;        // ratios that only the flat part explains
  int n_losing = 0;          // ratios below kLargestMeanEps
  double start_score = 0.0;  // of the recording before this train
  int n_eps = 0;             // intervals ratios seen
  std::int64_t impact = 0;
  std::int64_t n_heard = 2;
  std::size_t candidate = 0;
  std::int64_t previous = -1;  // state; -1 at the second impact of a train
  std::size_t first_candidate = 0;
};

/// Candidates within 2 ms, 4 ms ... 4 s: all of them, and those at least as strong.
struct Rivals {
  std::array<int, kOctaves> all{};
  std::array<int, kOctaves> stronger{};
};

std::vector<Rivals> count_rivals(const std::vector<Candidate>& c) {
  std::vector<Rivals> rivals(c.size());
  const double widest_s = kSmallestReach_s * std::ldexp(1.0, kOctaves - 1);
  for (std::size_t k = 0; k < c.size(); ++k) {
    const auto count = [&](std::size_t j) {
      const double distance = std::abs(c[j].t_s - c[k].t_s) / kSmallestReach_s;
      const int octave = distance <= 1.0 ? 0 : static_cast<int>(std::ceil(std::log2(distance)));
      if (octave >= kOctaves) return;
      ++rivals[k].all[octave];
      if (c[j].amplitude >= c[k].amplitude) ++rivals[k].stronger[octave];
    };
    for (std::size_t j = k; j < c.size() && c[j].t_s - c[k].t_s <= widest_s; ++j) count(j);
    for (std::size_t j = k; j-- > 0 && c[k].t_s - c[j].t_s <= widest_s;) count(j);
    for (int octave = 1; octave < kOctaves; ++octave) {
      rivals[k].all[octave] += rivals[k].all[octave - 1];
      rivals[k].stronger[octave] += rivals[k].stronger[octave - 1];
    }
  }
  return rivals;
}

/// Rate at which chance offers what this candidate offers, within about two flights of it. The candidate of rank r
/// among n gets the share 1/(r H_n), H_n = 1 + 1/2 + ... + 1/n: the strong ones are the likelier impacts, and summed
/// over all n the odds that chance alone would offer stay 1.
double chance_rate(const Rivals& rivals, double flight_s) {
  const int octave =
      std::clamp(static_cast<int>(std::lround(std::log2(2.0 * flight_s / kSmallestReach_s))), 0, kOctaves - 1);
  const double harmonic = std::log(rivals.all[octave]) + 0.5772 + 0.5 / rivals.all[octave];
  return rivals.stronger[octave] * harmonic / (2.0 * kSmallestReach_s * std::ldexp(1.0, octave));
}

/// eps such that the time since the last impact is flight (eps + eps^2 + ...), n_missing + 1 terms.
double eps_of_gap(double gap_over_flight, int n_missing) {
  double eps = gap_over_flight / (n_missing + 1);
  for (int iteration = 0; iteration < 5 && n_missing > 0; ++iteration) {
    double sum = 0.0;
    double slope = 0.0;
    double power = 1.0;
    for (int k = 0; k <= n_missing; ++k) {
      slope += (k + 1) * power;
      power *= eps;
      sum += power;
    }
    eps -= (sum - gap_over_flight) / slope;
  }
  return eps;
}

double student3(double x, double width) {
  const double z = x / width;
  return 2.0 / (kPi * std::sqrt(3.0) * width) / ((1.0 + z * z / 3.0) * (1.0 + z * z / 3.0));
}

/// Standard deviation of the next log eps about the running mean of the train.
double spread(const State& state, int n_missing, double timing_s) {
  const double jitter = 2.0 * timing_s / state.flight_s;
  const double n = std::clamp(state.n_eps, 1, kMemory);
  const double variance = (kScatterWeight * kScatter * kScatter + state.sum_squares) / (kScatterWeight + state.n_eps);
  return std::sqrt(variance * (1.0 + 1.0 / n) * (1.0 + n_missing) + jitter * jitter);
}

/// Density of log eps given the train so far.
double density(double log_eps, const State& state, double width) {
  constexpr double kFlat = kLargestEps - kLeastEps;
  const double flat = std::exp(log_eps) / kFlat;  // eps uniform
  if (state.n_eps == 0) return flat;
  return (1.0 - kOutlier) * student3(log_eps - state.mean_log_eps, width) + kOutlier * flat;
}

/// Odds that the amplitude goes with the train rather than with any sound: the sound of an impact is about as its
/// speed.
double log_odds_of_amplitude(double log_ratio, double log_eps) {
  const double deviation = log_ratio - log_eps;
  return std::log(student3(deviation, kAmplitudeScatter) / student3(deviation, kChanceAmplitude));
}

class Search {
 public:
  Search(const std::vector<Candidate>& candidates, double timing_s)
      : c_(candidates),
        timing_s_(timing_s),
        rivals_(count_rivals(candidates)),
        begin_(c_.size() + 1, 0),
        best_(c_.size() + 1) {}

  std::vector<Train> run() {
    for (std::size_t k = 0; k < c_.size(); ++k) visit(k);
    return trace();
  }

 private:
  struct Best {
    double score = 0.0;
    std::int64_t state = -1;  // the completed train that ends here or before
  };

  void visit(std::size_t k) {
    std::vector<State> here;
    for (std::size_t j = k; j-- > 0;) {
      const double gap_s = c_[k].t_s - c_[j].t_s;
      if (gap_s > kMostGap * kLongestFlight_s) break;
      // states are ordered by falling flight: those that can reach from j to k are the first
      for (std::size_t s = begin_[j]; s < begin_[j + 1] && states_[s].flight_s * kMostGap >= gap_s; ++s)
        extend(static_cast<std::int64_t>(s), k, here);
      start(j, k, here);
    }
    if (here.size() > kBeam) {
      std::nth_element(here.begin(), here.begin() + kBeam, here.end(),
                       [](const State& a, const State& b) { return a.score > b.score; });
      here.resize(kBeam);
    }
    double top = best_[k].score;
    for (const State& s : here) top = std::max(top, s.score);
    std::erase_if(here, [&](const State& s) { return s.score < top - kBeamDepth; });
    std::sort(here.begin(), here.end(), [](const State& a, const State& b) { return a.flight_s > b.flight_s; });
    best_[k + 1] = best_[k];
    for (const State& s : here) {
      if (is_complete(s) && s.score > best_[k + 1].score)
        best_[k + 1] = {s.score, static_cast<std::int64_t>(states_.size())};
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

  void start(std::size_t j, std::size_t k, std::vector<State>& here) const {
    const double flight_s = c_[k].t_s - c_[j].t_s;
    if (flight_s < kShortestFirstFlight_s || flight_s > kLongestFlight_s) return;
    static const double kLogRange = std::log(kLongestFlight_s / kShortestFirstFlight_s);
    State s;
    s.flight_s = flight_s;
    s.start_score = best_[j].score;
    s.score = s.start_score - kStartCost - std::log(kLogRange * flight_s * chance_rate(rivals_[k], flight_s));
    s.impact = 1;
    s.candidate = k;
    s.first_candidate = j;
    keep(s, here);
  }

  void keep(const State& s, std::vector<State>& here) const {
    if (s.score - s.start_score < kHopeless) return;
    if (here.empty() || s.score > here.front().score) {
      here.push_back(s);
      std::swap(here.front(), here.back());
    } else if (s.score > here.front().score - kBeamDepth) {
      here.push_back(s);
    }
  }

  void extend(std::int64_t from_index, std::size_t k, std::vector<State>& here) const {
    const State& from = states_[static_cast<std::size_t>(from_index)];
    const double gap = (c_[k].t_s - c_[from.candidate].t_s) / from.flight_s;
    if (gap < kLeastEps || gap > kMostGap) return;
    if (!here.empty() && from.score + kMostGain < here.front().score - kBeamDepth) return;
    for (int n_missing = 0; n_missing <= kMostMissing; ++n_missing) {
      const double eps = eps_of_gap(gap, n_missing);
      if (eps < kLeastEps) break;
      if (eps > kLargestEps) continue;
      if (from.n_eps > 0 && (eps < kLeastOfMean * from.mean_eps || eps > kMostOfMean * from.mean_eps)) continue;
      double slope = 0.0;  // d(gap) / d(eps)
      double last_flight = 1.0;
      for (int m = 0; m <= n_missing; ++m) {
        slope += (m + 1) * last_flight;
        last_flight *= eps;
      }
      State s = from;
      s.flight_s = from.flight_s * last_flight;
      if (s.flight_s < kShortestFlight_s) continue;
      const double log_eps = std::log(eps);
      const double deviation = from.n_eps == 0 ? 0.0 : log_eps - from.mean_log_eps;
      const double width = spread(from, n_missing, timing_s_);
      const double per_second = density(log_eps, from, width) / (eps * slope * from.flight_s);
      s.score +=
          std::log(kHeard * std::pow(1.0 - kHeard, n_missing) * per_second / chance_rate(rivals_[k], s.flight_s));
      s.score +=
          log_odds_of_amplitude(std::log(c_[k].amplitude / c_[from.candidate].amplitude), (n_missing + 1) * log_eps);
      // one loss or gain must not carry the mean away
      double step = log_eps - from.mean_log_eps;
      if (from.n_eps > 0) step = std::clamp(step, -3.0 * width, 3.0 * width);
      s.n_eps = from.n_eps + 1;
      s.sum_squares = from.n_eps == 0 ? 0.0 : from.sum_squares + step * step * from.n_eps / s.n_eps;
      s.n_outliers += std::abs(deviation) > 4.0 * width ? 1 : 0;
      s.n_losing += eps < kLargestMeanEps ? 1 : 0;
      s.log_loss -= from.mean_log_eps + std::clamp(step, -0.5 * kLeastLogLoss, 0.5 * kLeastLogLoss);
      s.mean_log_eps += step / std::min(s.n_eps, kMemory);
      s.mean_eps = std::exp(s.mean_log_eps);
      s.impact += n_missing + 1;
      s.n_heard += 1;
      s.candidate = k;
      s.previous = from_index;
      keep(s, here);
    }
  }

  bool is_complete(const State& s) const {
    return s.n_heard >= static_cast<std::int64_t>(kLeastImpacts) && s.score - s.start_score >= kAcceptance &&
           c_[s.candidate].t_s - c_[s.first_candidate].t_s >= kShortestTrain_s &&
           static_cast<double>(s.impact + 1 - s.n_heard) <= 1.0 + kMostUnheard * static_cast<double>(s.n_heard) &&
           s.n_outliers <= 1 + kMostOutliers * s.n_eps && s.n_losing >= kLeastLosing * s.n_eps &&
           s.log_loss > std::max(kLeastLogLoss, -s.n_eps * std::log(kLargestMeanEps));
  }

  std::vector<Train> trace() const {
    std::vector<Train> trains;
    for (std::int64_t at = best_[c_.size()].state; at >= 0;) {
      Train train;
      const State* s = &states_[static_cast<std::size_t>(at)];
      train.log_odds = s->score - s->start_score;
      for (;; s = &states_[static_cast<std::size_t>(s->previous)]) {
        train.impacts.push_back({s->candidate, s->impact});
        if (s->previous < 0) break;
      }
      train.impacts.push_back({s->first_candidate, 0});
      std::reverse(train.impacts.begin(), train.impacts.end());
      at = best_[s->first_candidate].state;
      trains.push_back(std::move(train));
    }
    std::reverse(trains.begin(), trains.end());
    return trains;
  }

  const std::vector<Candidate>& c_;
  double timing_s_;
  std::vector<Rivals> rivals_;
  std::vector<State> states_;
  std::vector<std::size_t> begin_;  // states of candidate k: begin_[k] ... begin_[k+1]
  std::vector<Best> best_;          // best_[k]: over candidates before k
  std::size_t most_states_ = kStatesAtOnce;
};

}  // namespace

std::vector<Train> find_trains(const std::vector<Candidate>& candidates, double timing_s) {
  return Search(candidates, timing_s).run();
}

}  // namespace bouncelab
