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
      first_log_interval_(step.log_flight) {
  log_odds_rhythm_.fill(step.log_odds);
}

Hypothesis Hypothesis::begin(const Observation& first, const Observation& second, double same_source, bool is_counted,
                             const TrackingModel& model) {
  const Birth birth{log_odds_of_first(first, model), log(model.usual_eps)};
  return {first, second, *first_step(-INFINITY, birth, first, second, same_source, is_counted, model)};
}

void Hypothesis::take(const Step& step, const Observation& next, const TrackingModel& model) {
  follow_rhythm(next, next.log_rise_odds - log(step.of_clutter), model);
  BallHypothesis::take(step, next, model);
  log_probability_of_loss_ = log_probability_of_loss(model);
}

void Hypothesis::follow_rhythm(const Observation& next, double log_gain_of_clutter, const TrackingModel& model) {
  const double sigma_s = hypot(next.sigma_s, last().sigma_s);
  const auto before = rhythm_.log_interval();
  const auto densities = rhythm_.follow(next.t_s - last().t_s, next.log_amplitude, sigma_s, model);
  const auto after = rhythm_.log_interval();
  // the tempo of a rhythm stays within its range, normally distributed
  const auto of_range = [&](double first, std::size_t kind) {
    return 0.5 * (square(before[kind] - first) - square(after[kind] - first)) / square(model.tempo_range);
  };
  const double losing = log_odds_of_losing_ball();
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    if (losing + model.switch_log_odds > log_odds_ball_then_rhythm_[kind]) {
      log_odds_ball_then_rhythm_[kind] = losing + model.switch_log_odds;
      n_of_ball_[kind] = n_impacts;
      first_log_interval_after_[kind] = before[kind];
    }
    const double gain = log_gain_of_clutter + log(densities[kind]);
    log_odds_rhythm_[kind] += gain + of_range(first_log_interval_, kind);
    log_odds_ball_then_rhythm_[kind] += gain + of_range(first_log_interval_after_[kind], kind);
    most_log_odds_rhythm_[kind] = std::max(most_log_odds_rhythm_[kind], log_odds_rhythm_[kind]);
  }
}

double Hypothesis::log_odds_of_rhythm(std::size_t kind, const TrackingModel& model) const {
  return most_log_odds_rhythm_[kind] + model.rhythm_log_odds - model.start_log_odds;
}

double Hypothesis::log_odds_of_ball(const TrackingModel& model) const {
  double others = 0.0;  // log odds of clutter, and of rhythms
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) others = log_of_sum(others, log_odds_of_rhythm(kind, model));
  return log_odds_of_losing_ball() - others;
}

Hypothesis::Verdict Hypothesis::most_probable(const TrackingModel& model) const {
  Verdict most{Explanation::ball, log_odds_of_losing_ball(), n_impacts};
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    const double rhythm = log_odds_of_rhythm(kind, model);
    if (rhythm > most.log_odds) most = {Explanation::rhythm, rhythm, 0};
    if (log_odds_ball_then_rhythm_[kind] > most.log_odds)
      most = {Explanation::ball_then_rhythm, log_odds_ball_then_rhythm_[kind], n_of_ball_[kind]};
  }
  return most;
}

}  // namespace bouncelab::detection
