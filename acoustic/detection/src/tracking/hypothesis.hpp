// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "tracking/bounces.hpp"
#include "tracking/observations.hpp"
#include "tracking/rhythm.hpp"

namespace bouncelab::detection {

/// A hypothesis: that a sequence of observations are the impacts of one ball. The same sounds are followed as a rhythm,
/// which a ball has to surpass. All odds are natural logarithms against clutter, so that sequences of any length
/// compare:
///
///   sum over impacts of log{ p(t, a | state) w / [ lambda(t, a) ] } + log p(LLR | event)/p(LLR) + prior of the birth
///
/// with the density of time and log amplitude under the ball, the weight w of one source, and the intensity of the
/// clutter (neighbours.hpp).
///
/// What an impact would add is a Step, which costs less than to take it: most steps are never taken.
class Hypothesis {
 public:
  /// One more impact, or the second.
  struct Step {
    double log_odds = 0.0;    ///< of the ball with it
    double flight_s = 0.0;    ///< last interval then, or what it would have been
    double log_flight = 0.0;  ///< [ln s]
    double log_eps = 0.0;
    double jitter2 = 0.0;     ///< variance that errors of the times add to log eps
    double of_clutter = 0.0;  ///< intensity of the clutter over the weight of one source
    int n_missing = 0;        ///< impacts before it that were not detected
  };

  /// The first two impacts; absent below the least log odds that are of interest.
  /// @param same_source  weight of one source, 0 ... 1
  /// @param is_counted   whether the track's own sounds are among its observations' neighbours
  static std::optional<Step> first_step(const Observation& first, const Observation& second, double same_source,
                                        bool is_counted, double least_log_odds = -INFINITY);
  Hypothesis(const Observation& first, const Observation& second, const Step& step);
  /// A track that begins with two impacts, whatever its odds.
  static Hypothesis begin(const Observation& first, const Observation& second, double same_source, bool is_counted);

  /// One more impact after n_missing that were not detected; absent where no ball does that, or below the least log
  /// odds that are of interest.
  std::optional<Step> step_to(const Observation& next, int n_missing, double same_source, bool is_counted,
                              double least_log_odds = -INFINITY) const;
  /// @param step  to `next`
  void take(const Step& step, const Observation& next);

  /// Of a ball that loses energy against clutter.
  double log_odds_of_losing_ball() const { return log_odds + log_probability_of_loss_; }
  /// Of a rhythm of either kind, which may have ended before, against clutter.
  double log_odds_of_rhythm() const;
  /// Of the ball against clutter, rhythms, and what loses no energy.
  double log_odds_of_ball() const;

  double log_odds = 0.0;       ///< of the ball, whether it loses energy or not
  double flight_s = 0.0;       ///< last interval, or what it would have been
  std::int64_t impact = 1;     ///< number of the last
  std::int64_t n_impacts = 2;  ///< detected

 private:
  struct Impact {
    double t_s = -1e9;  ///< long ago: there was none
    double log_amplitude = 0.0;
    double sigma_s = 0.0;
  };
  double own_density(const Observation& next, const Flight& flight, double log_eps, double same_source) const;
  double jitter2(const Observation& next) const;

  std::array<Impact, 3> last_;  ///< the last first
  double log_flight_;
  Bounces bounces_;
  double log_probability_of_loss_ = 0.0;  ///< that it loses energy, as no rhythm does
  Rhythm rhythm_;
  std::array<double, kRhythmKinds> log_odds_rhythm_;
  std::array<double, kRhythmKinds> most_log_odds_rhythm_{-1e9, -1e9};  ///< of one that ended there
};

/// Log odds that `before` is the impact before a track's first one.
/// @param flight_s      the track's first interval
/// @param mean_log_eps  of the track's first impacts, and how much they scatter
double log_odds_before(const Observation& before, const Observation& first, double same_source, double flight_s,
                       double mean_log_eps, double scatter);

}  // namespace bouncelab::detection
