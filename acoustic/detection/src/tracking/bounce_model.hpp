// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "candidates/candidates.hpp"
#include "tracking/clutter.hpp"

namespace bouncelab::detection {

// limits of what is followed
constexpr double kShortestFirstFlight_s = 40e-3;  // a train begins with 0.2 m/s or more, a drop from 2 mm
constexpr double kLongestFlight_s = 2.5;          // a fall from 7.6 m
constexpr double kLeastEps = 0.4;                 // a basketball on carpet has 0.5
constexpr double kLargestEps = 1.2;               // single gains of a spinning ball
constexpr double kEcho_s = 40e-3;                 // after an impact: what is fainter then is taken for its echo
constexpr int kMostMissing = 2;                   // impacts in a row that were not heard
constexpr double kAcceptance = 0.5;               // log odds a train must reach, all that speaks against it counted
constexpr double kMostGap = kLargestEps * (1.0 + kLargestEps * (1.0 + kLargestEps));  // of the last flight

/// A candidate as the model of trains sees it.
struct HeardSound {
  const Candidate& candidate;
  const Rivals& rivals;
  double sigma_s = 0.0;  ///< error of its time
  double log_amplitude = 0.0;
  double log_rise_odds = 0.0;   ///< what its rise says for an event (clutter.hpp)
  double log_odds_first = 0.0;  ///< of a train that begins with it
  std::optional<double> alike;  ///< probability that it and the train's last are of one kind; absent = not judged
  bool own_are_rivals = true;   ///< whether the train's own sounds were counted among its rivals
};

/// What a train is up to an impact.
struct TrainState {
  double log_odds = 0.0;  ///< ball against clutter
  /// The same sounds as a rhythm against clutter: by hand, of a machine.
  std::array<double, 2> log_odds_rhythm{};
  std::array<double, 2> log_odds_ball_then_rhythm{-1e9, -1e9};  ///< as a ball that ends and a rhythm that begins there
  std::array<std::int64_t, 2> n_of_ball{};                      ///< of these, the sounds that are the ball's
  double flight_s = 0.0;                                        ///< last interval, or what it would have been
  double first_flight_s = 0.0;
  double mean_log_eps = 0.0;
  double mean_eps = 1.0;
  double sum_squares = 0.0;         ///< of the deviations of log eps from its running mean, large ones cut
  double log_loss = 0.0;            ///< -sum of log eps, large deviations cut
  int n_eps = 0;                    ///< ratios of intervals seen
  double mean_log_loudness = 0.0;   ///< of log amplitude over flight: what a ball keeps
  double mean_log_amplitude = 0.0;  ///< what a rhythm keeps
  double log_beat = 0.0;            ///< of a rhythm: log of its interval
  double log_beat_drift = 0.0;      ///< its change from beat to beat
  double last_log_beat = 0.0;       ///< of the last interval
  double sum_squares_beat = 0.0;
  std::int64_t impact = 1;
  std::int64_t n_heard = 2;
  double first_s = 0.0;
  struct Heard {
    double t_s = -1e9;
    double log_amplitude = 0.0;
    double sigma_s = 0.0;
  };
  std::array<Heard, 3> last{};  ///< the last first; long ago = there was none

  /// Ball against clutter, rhythm, and what loses no energy.
  double log_odds_of_ball() const;
};

/// Prior log odds of a train that begins with a candidate, against clutter.
double log_odds_of_first(const Rivals& rivals, double log_rise_odds);

TrainState begin_train(const HeardSound& first, const HeardSound& second);

/// The train with one more impact, n_missing unheard ones before it; nothing where no ball does that, or with log odds
/// below the least that are of interest.
std::optional<TrainState> extend_train(const TrainState& train, int n_missing, const HeardSound& next,
                                       double least_log_odds);

/// Log odds against chance and rhythm that `before` is the impact before a train's first one.
/// @param flight_s      the train's first interval
/// @param mean_log_eps  of the train's first impacts, and how much they scatter
double log_odds_before(const HeardSound& before, const HeardSound& first, double flight_s, double mean_log_eps,
                       double scatter);

}  // namespace bouncelab::detection
