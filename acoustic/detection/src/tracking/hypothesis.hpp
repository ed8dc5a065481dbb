// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "tracking/ball_hypothesis.hpp"
#include "tracking/observations.hpp"
#include "tracking/rhythm.hpp"

namespace bouncelab::detection {

/// A hypothesis: that a sequence of observations are the impacts of one ball. The same sounds are followed as a rhythm,
/// which a ball has to surpass.
class Hypothesis : public BallHypothesis {
 public:
  Hypothesis(const Observation& first, const Observation& second, const Step& step);
  Hypothesis() = default;

  /// A track that begins with two impacts.
  /// @param same_source  weight of one source, 0 ... 1
  /// @param is_counted   whether the track's own sounds are among its observations' neighbours
  static Hypothesis begin(const Observation& first, const Observation& second, double same_source, bool is_counted);
  /// @param step  to `next`
  void take(const Step& step, const Observation& next);

  /// Of a ball that loses energy against clutter.
  double log_odds_of_losing_ball() const { return log_odds + log_probability_of_loss_; }
  /// Of a rhythm of either kind, which may have ended before, against clutter.
  double log_odds_of_rhythm() const;
  /// Of the ball against clutter, rhythms, and what loses no energy.
  double log_odds_of_ball() const;

 private:
  Rhythm rhythm_;
  double log_probability_of_loss_ = 0.0;
  std::array<double, kRhythmKinds> log_odds_rhythm_{};
  std::array<double, kRhythmKinds> most_log_odds_rhythm_{-1e9, -1e9};  ///< of one that ended there
};

}  // namespace bouncelab::detection
