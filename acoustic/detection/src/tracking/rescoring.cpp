// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rescoring.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "tracking/bounce_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kStranger = 1.0;      // log odds against a ball of each sound like its own but not of it
constexpr double kSureLogOdds = 40.0;  // more need not be told exactly

/// The coefficient of restitution that goes before the first of a train.
struct Expected {
  double log_eps = 0.0;
  double scatter = 0.0;
};

/// By the line through its first ones, which follows eps(v); a mean where they are few.
std::optional<Expected> expected_before(const std::vector<Candidate>& c, const Train& train) {
  constexpr std::size_t kFirst = 10;
  constexpr std::size_t kFewestForLine = 5;
  std::vector<double> log_eps;
  for (std::size_t k = 2; k < std::min(kFirst, train.impacts.size()); ++k) {
    if (train.impacts[k].impact - train.impacts[k - 2].impact != 2) continue;
    const double t1_s = c[train.impacts[k - 1].candidate].t_s;
    log_eps.push_back(log((c[train.impacts[k].candidate].t_s - t1_s) / (t1_s - c[train.impacts[k - 2].candidate].t_s)));
  }
  if (log_eps.size() < 2) return {};
  const auto n = static_cast<double>(log_eps.size());
  const double middle = 0.5 * (n - 1.0);
  const double mean = std::accumulate(log_eps.begin(), log_eps.end(), 0.0) / n;
  const double sum_x2 = n * (n * n - 1.0) / 12.0;
  double slope = 0.0;
  if (log_eps.size() >= kFewestForLine)
    for (std::size_t k = 0; k < log_eps.size(); ++k) slope += (static_cast<double>(k) - middle) * log_eps[k] / sum_x2;
  double squares = 0.0;
  for (std::size_t k = 0; k < log_eps.size(); ++k) {
    const double off = log_eps[k] - mean - slope * (static_cast<double>(k) - middle);
    squares += off * off;
  }
  const double reach = middle + 1.0;
  if (log_eps.size() < kFewestForLine) return Expected{mean, std::sqrt(squares / (n - 1.0) * (1.0 + 1.0 / n))};
  return Expected{mean - slope * reach, std::sqrt(squares / (n - 2.0) * (1.0 + 1.0 / n + reach * reach / sum_x2))};
}

constexpr double kEchoOfFlight = 0.15;  // where it is short, what follows may be anything

/// The train's own sounds and their echoes: chance need not offer them.
std::vector<std::size_t> explained_by(const HeardSounds& sounds, const std::vector<std::size_t>& own) {
  const std::vector<Candidate>& c = sounds.candidates;
  std::vector<std::size_t> explained;
  for (std::size_t n = 0; n < own.size(); ++n) {
    const bool is_last = n + 1 == own.size();
    const double flight_s = is_last ? c[own[n]].t_s - c[own[n - 1]].t_s : c[own[n + 1]].t_s - c[own[n]].t_s;
    const double echo_s = std::min(kEcho_s, kEchoOfFlight * flight_s);
    explained.push_back(own[n]);
    for (std::size_t k = own[n] + 1; k < c.size() && c[k].t_s - c[own[n]].t_s < echo_s; ++k)
      if (c[k].amplitude < c[own[n]].amplitude) explained.push_back(k);
  }
  return explained;
}

/// The first impact was chosen before the ball was known, and those before it may have cost odds then: now it stands
/// for choice again, and impacts before it are looked for.
/// @param first_free  candidates before this one belong to the train before
void begin_again(const HeardSounds& sounds, std::size_t first_free, Train& train) {
  constexpr std::size_t kKnown = 6;  // impacts, without the first, from which a ball is known
  // what comes before a drop is seldom silence: odds of two where it is a ball, of five where that is not sure
  constexpr double kSureBall = 12.0;
  const double believed = train.log_odds > kSureBall ? 0.7 : 1.6;
  const std::vector<Candidate>& c = sounds.candidates;
  std::optional<std::size_t> given;
  if (train.impacts.size() > kKnown && train.impacts[1].impact == train.impacts[0].impact + 1) {
    given = train.impacts[0].candidate;
    train.impacts.erase(train.impacts.begin());
  }
  const std::optional<Expected> expected = expected_before(c, train);
  std::vector<std::size_t> own;
  for (const TrainImpact& impact : train.impacts) own.push_back(impact.candidate);
  const std::vector<std::size_t> explained = explained_by(sounds, own);
  while (expected && train.impacts[1].impact == train.impacts[0].impact + 1) {
    const std::size_t first = train.impacts[0].candidate;
    const double flight_s = c[train.impacts[1].candidate].t_s - c[first].t_s;
    const auto odds_of = [&](std::size_t k) {
      const Rivals rivals = count_rivals_of(k, c, sounds.band_energies, explained);
      const HeardSound heard = sounds.heard(k);
      const HeardSound earlier{c[k],
                               rivals,
                               heard.sigma_s,
                               heard.log_amplitude,
                               heard.log_rise_odds,
                               heard.log_odds_first,
                               sounds.alike(k, first),
                               false};
      return log_odds_before(earlier, sounds.heard(first), flight_s, expected->log_eps, expected->scatter);
    };
    const double least = given ? odds_of(*given) : believed;
    double best = least;
    std::size_t before = given.value_or(first);
    const double furthest_s = std::min(kLongestFlight_s, flight_s / kLeastEps);
    for (std::size_t k = first; k-- > first_free && c[first].t_s - c[k].t_s < furthest_s;) {
      const double odds = odds_of(k);
      if (odds > best) best = odds, before = k;
    }
    if (before == first) break;
    train.impacts.insert(train.impacts.begin(), {before, train.impacts[0].impact - 1});
    train.log_odds += given ? best - least : best;
    given.reset();
  }
  if (given) train.impacts.insert(train.impacts.begin(), {*given, train.impacts[0].impact - 1});
  const std::int64_t shift = train.impacts.front().impact;
  for (TrainImpact& impact : train.impacts) impact.impact -= shift;
}

/// Sounds among a train's that are like its own and about as loud, but not of it: a ball leaves none, a row of knocks
/// or steps in which intervals happen to shrink, many. Echoes of its own do not count.
double n_strangers(const HeardSounds& sounds, const std::vector<std::size_t>& own) {
  constexpr double kAsLoud = 0.5;
  if (sounds.band_energies.empty()) return 0.0;
  const std::vector<Candidate>& c = sounds.candidates;
  constexpr double kFlights = 1.25;  // before the first and after the last, where a row would go on
  const double begin_s = c[own[0]].t_s - kFlights * (c[own[1]].t_s - c[own[0]].t_s);
  const double end_s = c[own.back()].t_s + kFlights * (c[own.back()].t_s - c[own[own.size() - 2]].t_s);
  double n = 0.0;
  std::size_t next = 0;  // own sound that comes after
  const auto first = std::partition_point(c.begin(), c.end(), [&](const Candidate& s) { return s.t_s < begin_s; });
  for (auto k = static_cast<std::size_t>(first - c.begin()); k < c.size() && c[k].t_s < end_s; ++k) {
    while (next < own.size() && own[next] < k) ++next;
    if (next < own.size() && own[next] == k) continue;
    const std::size_t near = own[next > 0 ? next - 1 : 0];
    const bool is_echo = next > 0 && c[k].t_s - c[near].t_s < kEcho_s;
    if (!is_echo && c[k].amplitude > kAsLoud * c[near].amplitude)
      n += std::max(0.0, 2.0 * *sounds.alike(near, k) - 1.0);
  }
  return n;
}

/// Log odds of a train where what it explains is no rival of its sounds.
double judged(const HeardSounds& sounds, const Train& train) {
  std::vector<std::size_t> own;
  for (const TrainImpact& impact : train.impacts) own.push_back(impact.candidate);
  const std::vector<std::size_t> explained = explained_by(sounds, own);
  std::vector<Rivals> rivals;
  for (const std::size_t k : own)
    rivals.push_back(count_rivals_of(k, sounds.candidates, sounds.band_energies, explained));
  const auto sound = [&](std::size_t n) {
    const HeardSound s = sounds.heard(own[n]);
    return HeardSound{s.candidate,
                      rivals[n],
                      s.sigma_s,
                      s.log_amplitude,
                      s.log_rise_odds,
                      log_odds_of_first(rivals[n], s.log_rise_odds),
                      n > 0 ? sounds.alike(own[n - 1], own[n]) : std::nullopt,
                      false};
  };
  std::optional<TrainState> state = begin_train(sound(0), sound(1));
  for (std::size_t n = 2; n < own.size() && state; ++n) {
    const auto n_missing = static_cast<int>(train.impacts[n].impact - train.impacts[n - 1].impact - 1);
    state = extend_train(*state, n_missing, sound(n), -INFINITY);
  }
  return state ? state->log_odds_of_ball() - kStranger * n_strangers(sounds, own) : train.log_odds;
}

/// What comes within 40 ms after something louder is its echo rather than a first impact: where the louder one fits
/// about as well, the train begins there.
void begin_at_source(const HeardSounds& sounds, std::size_t first_free, Train& train) {
  constexpr double kAsWell = 2.0;  // log odds of the echo against its source, by which intervals may prefer it
  const std::vector<Candidate>& c = sounds.candidates;
  const std::size_t first = train.impacts[0].candidate;
  double best = judged(sounds, train) - kAsWell;
  Train other = train;
  for (std::size_t k = first; k-- > first_free && c[first].t_s - c[k].t_s < kEcho_s;) {
    if (c[k].amplitude < c[first].amplitude) continue;
    other.impacts[0].candidate = k;
    const double odds = judged(sounds, other);
    if (odds > best) best = odds, train.impacts[0].candidate = k;
  }
}

/// ln of a train's first coefficient of restitution; absent where an impact is missing.
std::optional<double> first_log_eps(const std::vector<Candidate>& c, const Train& train) {
  if (train.impacts[2].impact != 2) return {};
  const double t1_s = c[train.impacts[1].candidate].t_s;
  return log((c[train.impacts[2].candidate].t_s - t1_s) / (t1_s - c[train.impacts[0].candidate].t_s));
}

/// One recording, one ball: log odds that a train's eps, which was open, is that of the surest other train.
double odds_of_same_ball(const std::vector<Candidate>& c, const std::vector<Train>& trains, const Train& train) {
  constexpr double kScatterOfDrops = 0.06;  // of ln eps between drops of one ball at other speeds
  constexpr double kAnother = 0.4;          // another ball, or another floor
  constexpr double kEpsRange = kLargestEps - kLeastEps;
  const Train* surest = nullptr;
  for (const Train& other : trains)
    if (&other != &train && other.log_odds > kAcceptance + 3.0 &&
        (surest == nullptr || other.log_odds > surest->log_odds))
      surest = &other;
  const std::optional<double> here = first_log_eps(c, train);
  const std::optional<double> there = surest != nullptr ? first_log_eps(c, *surest) : std::nullopt;
  if (!here || !there) return 0.0;
  const double open = exp(*here) / kEpsRange;  // eps uniform, as the model has it
  return log((1.0 - kAnother) * student3(*here - *there, kScatterOfDrops) / open + kAnother);
}

}  // namespace

void review_trains(const HeardSounds& sounds, std::vector<Train>& trains) {
  std::size_t first_free = 0;
  for (Train& train : trains) {
    begin_again(sounds, first_free, train);
    if (train.log_odds < kSureLogOdds) begin_at_source(sounds, first_free, train);
    first_free = train.impacts.back().candidate + 1;
  }
  for (Train& train : trains) train.log_odds = judged(sounds, train);
  const std::vector<Train> all = trains;
  for (std::size_t k = 0; k < trains.size(); ++k)
    if (trains[k].log_odds < kSureLogOdds) trains[k].log_odds += odds_of_same_ball(sounds.candidates, all, all[k]);
  std::erase_if(trains, [](const Train& train) { return train.log_odds < kAcceptance; });
}

}  // namespace bouncelab::detection
