// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/hypothesis.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"

namespace bouncelab::detection {

Hypothesis::Hypothesis(const Observation& first, const Observation& second, const Step& step)
    : BallHypothesis(first, second, step),
      rhythm_(step.log_flight, 0.5 * (first.log_amplitude + second.log_amplitude)),
      log_odds_rhythm_{step.log_odds, step.log_odds} {}

Hypothesis Hypothesis::begin(const Observation& first, const Observation& second, double same_source, bool is_counted) {
  const Birth birth{log_odds_of_first(first), log(kTracking.usual_eps)};
  return {first, second, *first_step(-INFINITY, birth, first, second, same_source, is_counted)};
}

void Hypothesis::take(const Step& step, const Observation& next) {
  const double sigma_s = hypot(next.sigma_s, last().sigma_s);
  const auto densities = rhythm_.follow(next.t_s - last().t_s, next.log_amplitude, sigma_s);
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    log_odds_rhythm_[kind] += next.log_rise_odds + log(densities[kind] / step.of_clutter);
    most_log_odds_rhythm_[kind] = std::max(most_log_odds_rhythm_[kind], log_odds_rhythm_[kind]);
  }
  BallHypothesis::take(step, next);
  log_probability_of_loss_ = log_probability_of_loss();
}

double Hypothesis::log_odds_of_rhythm() const {
  return std::max(most_log_odds_rhythm_[0], most_log_odds_rhythm_[1]) + kTracking.rhythm_log_odds -
         kTracking.start_log_odds;
}

double Hypothesis::log_odds_of_ball() const {
  return log_odds_of_losing_ball() - log_of_sum(0.0, log_odds_of_rhythm());
}

}  // namespace bouncelab::detection
