// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// The timing noise that the samples themselves show. Neighbours share two onsets, and independent errors of standard
/// deviation s make
///
///   cov(eps_i, eps_{i+1}) = -s^2 (1 + eps_i)(1 + eps_{i+1}) / (T_i T_{i+1}),
///
/// while asperities make none (below 1 % of their variance). So s^2 = -mean of r_i r_{i+1} T_i T_{i+1} / (1 + eps)^2
/// over neighbours, r = eps - eps(v); its error from the scatter between drops (or between pairs, for fewer than 8
/// drops).
struct TimingNoise {
  std::size_t n_pairs = 0;
  double lag1_correlation = 0.0;  ///< of r / (local spread): 0 asperities only, -2/3 timing only
  double lag1_correlation_se = 0.0;
  double variance_s2 = 0.0;  ///< s^2; negative where the covariance is positive by chance
  double variance_se_s2 = 0.0;
  std::optional<double> sigma_s;   ///< root of it where positive
  double upper95_s = 0.0;          ///< one-sided 95 % limit
  std::optional<double> stated_s;  ///< median of what the samples' sigma_eps says
};
Description members_of(const TimingNoise*);

/// Where the scatter of eps and the shifts of eps(v) come from, in a bin of speeds. Spreads are standard deviations.
struct BudgetRow {
  double v_mps = 0.0;
  std::size_t n = 0;
  double spread = 0.0;                         ///< of eps - eps(v), all causes
  std::optional<double> spread_asperities;     ///< by the fit's scatter: sqrt(b_below^2 + b_above^2)
  std::optional<double> spread_timing_stated;  ///< by sigma_eps
  std::optional<double> spread_timing_lag1;    ///< by TimingNoise
  double spread_travel_time = 0.0;             ///< where it is present: eps * kick / wave speed
  /// Parts of the variance of eps - eps(v), together 1: what the fit finds of the ball, timing as stated (else by
  /// TimingNoise), travel time, and what these leave over.
  double share_asperities = 0.0, share_timing = 0.0, share_travel_time = 0.0, share_unexplained = 0.0;
  /// Of eps by the intervals, taken out or not; 0 where they hold no drag, absent where the ball is not known.
  std::optional<double> shift_drag;
  std::optional<double> shift_contact_time;  ///< likewise; absent also where the contact time is not known
  std::optional<double> mean_minus_peak;     ///< b_above - b_below: what least squares would be off by
};
Description members_of(const BudgetRow*);

struct ErrorBudget {
  std::optional<TimingNoise> timing;       ///< needs times and at least 8 pairs of neighbours
  std::optional<Estimate> width_exponent;  ///< k of spread ~ v^k; -1 in the paper
  std::vector<CurvePoint> width_law;       ///< that power law at the first and the last row
  std::vector<BudgetRow> rows;
  std::optional<Ball> ball;       ///< that the shifts were computed for
  std::optional<Material> plate;  ///< likewise
};
Description members_of(const ErrorBudget*);

/// What the shifts are computed for. Defaults: a recording of an unknown ball.
struct BudgetConfig {
  std::optional<Ball> ball;
  std::optional<Material> plate;
  Air air;
  double gravity_mps2 = kDefaultGravity_mps2;
  bool has_drag = true, has_contact_time = true;  ///< taken out of the samples or not; false: there was none
  bool has_travel_time = true;                    ///< not taken out
  /// An impact changes the ball's speed along the line to the sensor by a random kick, which changes the travel time of
  /// all later sound: d eps = eps kick / wave speed. Its rms per speed of impact; default: that of the simulated ball
  /// of the paper (uniform radii, found .0105 to .0112 from 0.2 to 1.4 m/s).
  double kick_per_speed = 0.011;
  double wave_speed_mps = 2500.0;  ///< in the plate; 343 for a microphone
};

/// `base` with what the samples say of themselves: what their intervals do not hold there is not, and ball, gravity and
/// wave speed are theirs where they are known. All must say the same: the first one's are taken.
BudgetConfig budget_config_of(const RestitutionSamples& samples, BudgetConfig base);

/// @param samples  that were fitted; t_s is needed for the timing noise only
/// @param law      fitted to them; without law.law the budget is empty
ErrorBudget error_budget(const RestitutionSamples& samples, const LawFit& law, const BudgetConfig& config);

}  // namespace bouncelab::fit
