// SPDX-License-Identifier: GPL-3.0-or-later
// Balls that bounce at the same time.
//
//   for each ball A that could be dropped if there were no rhythms, the longest first:
//     balls = {A}
//     repeat, with all of the last ball known, its first half, or its second; of the three results the most probable:
//             B = the longest ball in the sounds that are no impacts of `balls`, and at the same time
//             search A, B ... anew, each in the sounds that are no impacts of the others, until none changes
//             keep B if all together are more probable than without it, than one ball, or the tracks found one by one,
//             and B is neither an echo, one of many reflections, nor a codec's noise before impacts of A,
//             nor the rattling of a loose plate
//     if there are several: they take the place of the tracks found one by one
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "tracking/tracker.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kFewestAtOnce = 4;  // impacts of each of several balls
constexpr std::size_t kMostAtOnce = 8;    // balls
constexpr int kMostTurns = 4;             // of the search for each ball with the others explained

double begin_s(const Observations& o, const Track& track) { return o[track.impacts.front().candidate].t_s; }
double end_s(const Observations& o, const Track& track) { return o[track.impacts.back().candidate].t_s; }

bool is_any_during(const Observations& o, const std::vector<Track>& tracks, const Track& other) {
  return std::any_of(tracks.begin(), tracks.end(), [&](const Track& track) {
    return begin_s(o, track) <= end_s(o, other) && begin_s(o, other) <= end_s(o, track);
  });
}

bool have_same_impacts(const Track& a, const Track& b) {
  return std::equal(a.impacts.begin(), a.impacts.end(), b.impacts.begin(), b.impacts.end(),
                    [](const TrackImpact& x, const TrackImpact& y) { return x.candidate == y.candidate; });
}

bool has_impact(const Track& track, const TrackImpact& impact) {
  return std::any_of(track.impacts.begin(), track.impacts.end(),
                     [&](const TrackImpact& own) { return own.candidate == impact.candidate; });
}

std::vector<std::size_t> explained_by_all(const Observations& o, const std::vector<Track>& tracks) {
  return explained_by_others(o, tracks, tracks.size());
}

/// Impacts of all of them, rising.
std::vector<std::size_t> impacts_of(const std::vector<Track>& tracks) {
  std::vector<std::size_t> impacts;
  for (const Track& track : tracks)
    for (const TrackImpact& impact : track.impacts) impacts.push_back(impact.candidate);
  std::sort(impacts.begin(), impacts.end());
  return impacts;
}

/// The longest ball that bounces while one of the others does. Its impacts may be what is taken for an echo of others.
/// @param known  of the others, what is certain
std::optional<Track> ball_beside(const Observations& o, const std::vector<Track>& known,
                                 const std::vector<Track>& others) {
  double first_s = HUGE_VAL, last_s = -HUGE_VAL;
  for (const Track& other : others) {
    first_s = std::min(first_s, begin_s(o, other));
    last_s = std::max(last_s, end_s(o, other));
  }
  std::optional<Track> longest;
  std::size_t most = kFewestAtOnce - 1;
  for (Track& track : find_balls(o, impacts_of(known), explained_by_all(o, known), first_s - kLargestReach_s,
                                 last_s + kLargestReach_s)) {
    if (track.impacts.size() <= most || !is_any_during(o, others, track)) continue;
    most = track.impacts.size();
    longest = std::move(track);
  }
  return longest;
}

/// Searches each anew in the sounds that the others leave over, until none changes.
/// @return false where one is lost
bool settle(const Observations& o, std::vector<Track>& balls) {
  bool has_changed = true;
  for (int turn = 0; turn < kMostTurns && has_changed; ++turn) {
    has_changed = false;
    for (std::size_t b = 0; b < balls.size(); ++b) {
      std::vector<Track> others = balls;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(b));
      std::optional<Track> anew = ball_beside(o, others, others);
      if (!anew) return false;
      has_changed = has_changed || !have_same_impacts(*anew, balls[b]);
      balls[b] = std::move(*anew);
    }
  }
  return true;
}

/// A sound of one track that comes after an impact of another.
struct Follower {
  std::size_t candidate = 0;
  double after_s = 0.0;    ///< the impact
  double flight_s = 0.0;   ///< of the ball after the impact
  double log_ratio = 0.0;  ///< of the amplitudes
};

/// The sounds of a track that come after an impact of another one and before its next impact; after its last impact, as
/// long as its last flight took.
std::vector<Follower> followers_of(const Observations& o, const Track& of, const Track& track) {
  std::vector<Follower> followers;
  for (const TrackImpact& impact : track.impacts) {
    const Observation& sound = o[impact.candidate];
    std::size_t k = of.impacts.size();
    while (k > 0 && o[of.impacts[k - 1].candidate].t_s >= sound.t_s) --k;
    if (k == 0) continue;
    const Observation& before = o[of.impacts[k - 1].candidate];
    const bool is_last = k == of.impacts.size();
    const double flight_s =
        is_last ? before.t_s - o[of.impacts[k - 2].candidate].t_s : o[of.impacts[k].candidate].t_s - before.t_s;
    if (sound.t_s - before.t_s > flight_s) continue;
    followers.push_back(
        {impact.candidate, sound.t_s - before.t_s, flight_s, sound.log_amplitude - before.log_amplitude});
  }
  return followers;
}

/// Whether sounds of one track follow those of another by the same short time, half as many as the shorter one has.
bool is_echo(std::size_t n_of_shorter, const std::vector<Follower>& followers) {
  if (followers.empty()) return false;
  std::vector<double> log_ratio;
  for (const Follower& f : followers) log_ratio.push_back(f.log_ratio);
  // a faint one may come from farther away
  const double most_s = upper_median(std::move(log_ratio)) < log(0.5) ? 3.0 * kTracking.echo_s : kTracking.echo_s;
  return std::any_of(followers.begin(), followers.end(), [&](const Follower& middle) {
    const auto n_near = std::count_if(followers.begin(), followers.end(), [&](const Follower& f) {
      return std::abs(f.after_s - middle.after_s) < kTracking.same_echo_s;
    });
    return middle.after_s < most_s && 2 * static_cast<std::size_t>(n_near) >= n_of_shorter;
  });
}

/// Log odds against clutter that these sounds are some of many reflections: what follows other impacts of the ball by
/// the same time, as loud beside the impact, may follow this one too.
/// @param explained  by the track that they are of, and by all others
double log_odds_of_reflections(const Observations& o, const Track& ball, const std::vector<Follower>& followers,
                               const std::vector<std::size_t>& explained) {
  std::vector<Follower> sounds;
  for (std::size_t n = 0; n < ball.impacts.size(); ++n) {
    const Observation& impact = o[ball.impacts[n].candidate];
    const std::size_t end = n + 1 < ball.impacts.size() ? ball.impacts[n + 1].candidate : o.size();
    for (std::size_t k = ball.impacts[n].candidate + 1; k < end && o[k].t_s - impact.t_s < kTracking.echo_s; ++k)
      sounds.push_back({k, o[k].t_s - impact.t_s, 0.0, o[k].log_amplitude - impact.log_amplitude});
  }
  double log_odds = 0.0;
  for (const Follower& f : followers) {
    if (f.after_s > kTracking.echo_s) continue;
    double sum = 0.0;
    for (const Follower& other : sounds)
      if (other.candidate != f.candidate)
        sum += 0.5 * (student3(other.after_s - f.after_s, kTracking.timing_of_echo_s) + 1.0 / kTracking.echo_s) *
               amplitude_kernel(other.log_ratio - f.log_ratio);
    const double of_clutter = clutter_intensity(o.without(f.candidate, explained).neighbours, f.flight_s);
    log_odds += log1p(sum / static_cast<double>(ball.impacts.size()) / of_clutter);
  }
  return log_odds;
}

/// Log odds against clutter that the impacts set off these sounds: rattles of a loose plate. They come after a part of
/// the flight that is distributed exponentially, of any mean, and are louder or fainter than the impacts by one factor
/// that scatters as loudness does.
/// @param explained  by the track that they are of, and by all others
double log_odds_of_rattling(const Observations& o, const std::vector<Follower>& followers,
                            const std::vector<std::size_t>& explained) {
  if (followers.empty()) return -HUGE_VAL;
  double mean_log_ratio = 0.0;
  for (const Follower& f : followers) mean_log_ratio += f.log_ratio / static_cast<double>(followers.size());
  double of_amplitudes = 0.0;
  for (const Follower& f : followers)
    of_amplitudes += log(student3(f.log_ratio - mean_log_ratio, kTracking.loudness_scatter) /
                         clutter_intensity(o.without(f.candidate, explained).neighbours, f.flight_s));
  double of_times = -HUGE_VAL;
  for (const double mean_part : {0.05, 0.1, 0.2, 0.4}) {
    double sum = 0.0;
    for (const Follower& f : followers) sum -= f.after_s / (mean_part * f.flight_s) + log(mean_part * f.flight_s);
    of_times = std::max(of_times, sum);
  }
  return kTracking.rattle_log_odds + of_amplitudes + of_times;
}

/// Whether most sounds of the shorter track are next to impacts of the other: a codec puts noise
/// before an attack, at a time that depends on where its block begins, and tracks of both mix them.
bool are_beside(const Observations& o, const Track& a, const Track& b) {
  const auto n_beside = std::count_if(a.impacts.begin(), a.impacts.end(), [&](const TrackImpact& impact) {
    return std::any_of(b.impacts.begin(), b.impacts.end(), [&](const TrackImpact& other) {
      return std::abs(o[impact.candidate].t_s - o[other.candidate].t_s) < kTracking.pre_echo_s;
    });
  });
  return 4 * static_cast<std::size_t>(n_beside) >= 3 * std::min(a.impacts.size(), b.impacts.size());
}

/// Whether sounds of another track are better explained by the impacts of a ball: as their echoes, as noise of a codec,
/// or as the rattling of a loose plate.
/// @param log_odds   of the other track against chance
/// @param explained  by all balls
bool are_set_off_by(const Observations& o, const Track& ball, const Track& other, double log_odds,
                    const std::vector<std::size_t>& explained) {
  const std::vector<Follower> followers = followers_of(o, ball, other);
  return are_beside(o, ball, other) || is_echo(std::min(ball.impacts.size(), other.impacts.size()), followers) ||
         std::max(log_odds_of_reflections(o, ball, followers, explained),
                  log_odds_of_rattling(o, followers, explained)) > log_odds;
}

/// Sets the log odds of balls at once: each against chance and rhythms, and all together against fewer balls.
/// @param tracks    found one by one
/// @param proposal  the ball that they began with
/// @return of all together against chance; absent where one is less probable than not
std::optional<double> log_odds_together(const Observations& o, const std::vector<Track>& tracks, const Track& proposal,
                                        std::vector<Track>& balls) {
  const std::vector<std::size_t> explained = explained_by_all(o, balls);
  double together = 0.0, one = 0.0, one_by_one = 0.0;
  Track rest;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const LogOdds odds = log_odds_of(o, balls[b], explained_by_others(o, balls, b));
    for (const Track& other : balls)
      if (&other != &balls[b] && are_set_off_by(o, other, balls[b], odds.ball, explained)) return {};
    balls[b].log_odds = odds.ball_against_rhythm;
    together += odds.ball;
    one = std::max(one, log_odds_of(o, balls[b], {}).ball);
    std::copy_if(balls[b].impacts.begin(), balls[b].impacts.end(), std::back_inserter(rest.impacts),
                 [&](const TrackImpact& impact) { return !has_impact(proposal, impact); });
  }
  const double less = together - log_odds_of(o, proposal, impacts_of({rest})).ball;
  if (are_set_off_by(o, proposal, rest, less, explained)) return {};
  for (const Track& track : tracks)
    if (is_any_during(o, balls, track)) one_by_one += std::max(0.0, log_odds_of(o, track, {}).ball);
  for (Track& ball : balls) ball.log_odds = std::min(ball.log_odds, together - std::max(one, one_by_one));
  const bool are_probable =
      std::all_of(balls.begin(), balls.end(), [](const Track& ball) { return ball.log_odds > 0.0; });
  return are_probable ? std::optional(together) : std::nullopt;
}

/// A part of a track: `n` impacts from `first` on.
Track part_of(const Track& track, std::size_t first, std::size_t n) {
  const auto begin = track.impacts.begin() + static_cast<std::ptrdiff_t>(first);
  return {{begin, begin + static_cast<std::ptrdiff_t>(n)}, 0.0};
}

/// Whether the sounds during a track are enough for another ball beside it.
bool may_be_beside(const Track& track) {
  const std::size_t n_sounds = track.impacts.back().candidate - track.impacts.front().candidate + 1;
  return n_sounds >= track.impacts.size() + kFewestAtOnce;
}

/// Balls at the same time as this one, and this one: one more as long as a search from one of several starts finds one
/// and all are more probable with it. Where two balls' impacts cross, the last of them may have taken halves of both:
/// so either half of it may be wrong.
/// @param most  log odds of this one
std::vector<Track> balls_with(const Observations& o, const std::vector<Track>& tracks, const Track& proposal,
                              double most) {
  std::vector<Track> balls{proposal};
  for (bool has_more = true; has_more && balls.size() < kMostAtOnce;) {
    has_more = false;
    const std::vector<Track> before = balls;
    const Track& last = before.back();
    const std::size_t half = last.impacts.size() / 2;
    for (const Track& known : {last, part_of(last, 0, half), part_of(last, half, last.impacts.size() - half)}) {
      std::vector<Track> others = before;
      others.back() = known;
      std::optional<Track> another = ball_beside(o, others, before);
      if (!another || log_odds_of(o, *another, explained_by_all(o, others)).ball < 0.0) continue;
      others.back() = last;
      others.push_back(std::move(*another));
      if (!settle(o, others)) continue;
      const std::optional<double> together = log_odds_together(o, tracks, proposal, others);
      if (!together || *together <= most) continue;
      most = *together;
      balls = std::move(others);
      has_more = true;
    }
  }
  return balls;
}

}  // namespace

void add_balls_at_once(const Observations& o, std::vector<Track>& tracks) {
  std::vector<Track> proposals = find_balls(o, {}, {});
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const Track& a, const Track& b) { return a.impacts.size() > b.impacts.size(); });
  for (const Track& proposal : proposals) {
    if (proposal.impacts.size() < kFewestAtOnce || !may_be_beside(proposal)) continue;
    const double log_odds = log_odds_of(o, proposal, {}).ball;
    if (log_odds < 0.0) continue;
    std::vector<Track> balls = balls_with(o, tracks, proposal, log_odds);
    if (balls.size() == 1) continue;
    std::erase_if(tracks, [&](const Track& track) { return is_any_during(o, balls, track); });
    std::move(balls.begin(), balls.end(), std::back_inserter(tracks));
  }
  std::sort(tracks.begin(), tracks.end(),
            [](const Track& a, const Track& b) { return a.impacts.front().candidate < b.impacts.front().candidate; });
}

}  // namespace bouncelab::detection
