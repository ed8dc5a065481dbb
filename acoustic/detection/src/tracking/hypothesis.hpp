// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "tracking/bounces.hpp"
#include "tracking/observations.hpp"
#include "tracking/rhythm.hpp"

namespace bouncelab::detection {

/// A hypothesis: that a sequence of observations are the impacts of one ball. All odds are natural logarithms against
/// clutter, so that hypotheses of any length compare:
///
///   sum over impacts of log{ p(t, a | state) w / [ lambda(t, a) ] } + log p(LLR | event)/p(LLR) + prior of the birth
///
/// with the density of time and log amplitude under the ball, the weight w of one source, and the intensity of the
/// clutter (neighbours.hpp). The same sounds are followed as a rhythm, and as a ball that ends and a rhythm that begins
/// there, which a ball has to surpass.
class Hypothesis {
 public:
  /// A track that begins with two impacts.
  /// @param same_source  weight of one source, 0 ... 1
  /// @param is_counted   whether the track's own sounds are among its observations' neighbours
  static Hypothesis begin(const Observation& first, const Observation& second, double same_source, bool is_counted,
                          const TrackingModel& model);

  /// What many of them have in common.
  struct Birth {
    double log_odds_of_first = 0.0;  ///< log_odds_of_first() of the first impact
    double log_usual_eps = 0.0;
  };
  /// The same where its log odds are no less than those that are of interest.
  static std::optional<Hypothesis> begin_above(double least_log_odds, const Birth& birth, const Observation& first,
                                               const Observation& second, double same_source, bool is_counted,
                                               const TrackingModel& model);

  /// With one more impact after n_missing that were not detected; absent where no ball does that, or below the least
  /// log odds that are of interest.
  std::optional<Hypothesis> extended(const Observation& next, int n_missing, double same_source, bool is_counted,
                                     double least_log_odds, const TrackingModel& model) const;
  /// The same as a ball only, in less time: the rhythms stay behind, and `log_odds` alone is to be used of it.
  std::optional<Hypothesis> extended_as_ball(const Observation& next, int n_missing, double same_source,
                                             double least_log_odds, const TrackingModel& model) const;

  /// Log odds that an impact after n_missing may add at most, but for its rise.
  double largest_gain(int n_missing, const TrackingModel& model) const;

  /// What the sounds are explained by, with its log odds against clutter.
  enum class Explanation { ball, rhythm, ball_then_rhythm };
  struct Verdict {
    Explanation explanation = Explanation::ball;
    double log_odds = 0.0;
    std::int64_t n_of_ball = 0;  ///< observations that are the ball's
  };
  Verdict most_probable(const TrackingModel& model) const;

  /// Of the ball against clutter, rhythms, and what loses no energy.
  double log_odds_of_ball(const TrackingModel& model) const;

  double log_odds = 0.0;       ///< of the ball against clutter
  double flight_s = 0.0;       ///< last interval, or what it would have been
  std::int64_t impact = 1;     ///< number of the last
  std::int64_t n_impacts = 2;  ///< detected
  int n_eps() const { return bounces_.n_eps(); }

 private:
  struct Impact {
    double t_s = -1e9;  ///< long ago: there was none
    double log_amplitude = 0.0;
    double sigma_s = 0.0;
  };
  template <bool with_rhythms>
  std::optional<Hypothesis> extended_as(const Observation& next, int n_missing, double same_source, bool is_counted,
                                        double least_log_odds, const TrackingModel& model) const;
  double own_density(const Observation& next, const Flight& flight, double log_eps, double same_source,
                     const TrackingModel& model) const;
  double log_odds_of_rhythm(std::size_t kind, const TrackingModel& model) const;
  double log_odds_of_losing_ball(const TrackingModel& model) const;
  double jitter2(const Observation& next) const;
  void follow_rhythm(const Observation& next, double log_gain_of_clutter, const TrackingModel& model);

  std::array<Impact, 3> last_{};  ///< the last first
  double log_flight_ = 0.0;
  Bounces bounces_;
  Rhythm rhythm_;
  std::array<double, kRhythmKinds> log_odds_rhythm_{};
  std::array<double, kRhythmKinds> most_log_odds_rhythm_{-1e9, -1e9};  ///< of one that ended there
  std::array<double, kRhythmKinds> log_odds_ball_then_rhythm_{-1e9, -1e9};
  std::array<std::int64_t, kRhythmKinds> n_of_ball_{};
  double first_log_interval_ = 0.0;                              ///< of the rhythm [ln s]
  std::array<double, kRhythmKinds> first_log_interval_after_{};  ///< of the rhythm after the ball
};

/// Log odds of a track that begins with an observation, before its second impact.
double log_odds_of_first(const Observation& first, const TrackingModel& model);

/// Log odds that `before` is the impact before a track's first one.
/// @param flight_s      the track's first interval
/// @param mean_log_eps  of the track's first impacts, and how much they scatter
double log_odds_before(const Observation& before, const Observation& first, double same_source, double flight_s,
                       double mean_log_eps, double scatter, const TrackingModel& model);

}  // namespace bouncelab::detection
