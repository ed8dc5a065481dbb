// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "tracking/ball_hypothesis.hpp"
#include "tracking/observations.hpp"
#include "tracking/rhythm.hpp"

namespace bouncelab::detection {

/// A hypothesis: that a sequence of observations are the impacts of one ball. The same sounds are followed as a rhythm,
/// and as a ball that ends and a rhythm that begins there, which a ball has to surpass.
class Hypothesis : public BallHypothesis {
 public:
  Hypothesis(const Observation& first, const Observation& second, const Step& step);
  Hypothesis() = default;

  /// A track that begins with two impacts.
  /// @param same_source  weight of one source, 0 ... 1
  /// @param is_counted   whether the track's own sounds are among its observations' neighbours
  static Hypothesis begin(const Observation& first, const Observation& second, double same_source, bool is_counted,
                          const TrackingModel& model);
  /// @param step  to `next`
  void take(const Step& step, const Observation& next, const TrackingModel& model);

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

 private:
  double log_odds_of_rhythm(std::size_t kind, const TrackingModel& model) const;
  double log_odds_of_losing_ball() const { return log_odds + log_probability_of_loss_; }
  void follow_rhythm(const Observation& next, double log_gain_of_clutter, const TrackingModel& model);

  Rhythm rhythm_;
  double log_probability_of_loss_ = 0.0;
  std::array<double, kRhythmKinds> log_odds_rhythm_{};
  std::array<double, kRhythmKinds> most_log_odds_rhythm_{-1e9, -1e9};  ///< of one that ended there
  std::array<double, kRhythmKinds> log_odds_ball_then_rhythm_{-1e9, -1e9};
  std::array<std::int64_t, kRhythmKinds> n_of_ball_{};
  double first_log_interval_ = 0.0;                              ///< of the rhythm [ln s]
  std::array<double, kRhythmKinds> first_log_interval_after_{};  ///< of the rhythm after the ball
};

}  // namespace bouncelab::detection
