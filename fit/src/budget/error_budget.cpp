// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/error_budget.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "budget/timing_noise.hpp"
#include "law/columns.hpp"
#include "law/distributions.hpp"

namespace bouncelab::fit {

const char* to_string(Effect effect) {
  switch (effect) {
    case Effect::absent:
      return "absent";
    case Effect::present:
      return "not taken out";
    case Effect::corrected:
      return "taken out";
  }
  return "unknown";
}

namespace {

/// What drag does to eps at a speed, uncorrected: two flights with the true eps between them.
std::optional<double> shift_by_drag(double v_mps, double eps, const BudgetConfig& config) {
  if (!config.ball) return std::nullopt;
  const double before_s = 2.0 * v_mps / config.gravity_mps2;
  const Flight before = flight_with_drag(*config.ball, config.air, before_s, config.gravity_mps2);
  const Flight after = flight_with_drag(*config.ball, config.air, eps * before_s, config.gravity_mps2);
  return eps - after.launch_mps / before.landing_mps;
}

std::optional<double> shift_by_contact_time(double v_mps, double eps, const BudgetConfig& config) {
  if (!config.ball || !(config.plate || config.ball->contact_time_s)) return std::nullopt;
  const double before_s = 2.0 * v_mps / config.gravity_mps2;
  const Material plate = config.plate.value_or(Material{});
  const std::optional<double> contact_before_s = contact_time_s(*config.ball, plate, v_mps / eps);
  const std::optional<double> contact_after_s = contact_time_s(*config.ball, plate, v_mps);
  if (!contact_before_s || !contact_after_s) return std::nullopt;
  return (eps * before_s + *contact_after_s) / (before_s + *contact_before_s) - eps;
}

/// Parts of the variance; they are scaled down where together they exceed what is there (timing stated too large).
void add_shares(BudgetRow& row) {
  const double ball = square(row.spread_asperities.value_or(0.0));
  const auto& timing_spread = row.spread_timing_stated ? row.spread_timing_stated : row.spread_timing_lag1;
  const double timing = square(timing_spread.value_or(0.0)), travel = row.spread_travel_time * row.spread_travel_time;
  const double total = std::max(row.spread * row.spread, ball + timing + travel);
  if (!(total > 0.0)) return;
  row.share_asperities = ball / total;
  row.share_timing = timing / total;
  row.share_travel_time = travel / total;
  row.share_unexplained = 1.0 - (ball + timing + travel) / total;
}

struct BinMember {
  double v_mps;
  const RestitutionSample* sample;
  double residual;  ///< from the law
};

BudgetRow budget_row(std::span<const BinMember> bin, const LawFit& law, const BudgetConfig& config,
                     const std::optional<TimingNoise>& timing) {
  BudgetRow row;
  row.n = bin.size();
  const auto n = static_cast<double>(row.n);
  row.v_mps = bin[bin.size() / 2].sample->v_mps;
  double squares = 0.0, stated = 0.0, n_stated = 0.0, mean = 0.0;
  for (const BinMember& member : bin) mean += member.residual / n;
  for (const BinMember& member : bin) {
    squares += square(member.residual - mean);
    if (!member.sample->sigma_eps) continue;
    stated += square(*member.sample->sigma_eps);
    n_stated += 1.0;
  }
  row.spread = std::sqrt(squares / std::max(1.0, n - 1.0));
  if (n_stated > 0.0) row.spread_timing_stated = std::sqrt(stated / n_stated);
  const double eps = restitution(*law.law, row.v_mps), interval_s = 2.0 * row.v_mps / config.gravity_mps2;
  if (timing && timing->sigma_s)
    row.spread_timing_lag1 = *timing->sigma_s * std::sqrt(1.0 + (1.0 + eps) * (1.0 + eps) + eps * eps) / interval_s;
  if (law.scatter) {
    const double below = law.scatter->below(row.v_mps), above = law.scatter->above(row.v_mps);
    row.spread_asperities =
        law.method == LawMethod::least_squares ? below : hypot(hypot(below, above), law.scatter->normal(row.v_mps));
    row.mean_minus_peak = law.method == LawMethod::asymmetric_laplace ? law.scatter->mean_minus_peak(row.v_mps) : 0.0;
  }
  const auto point = std::min_element(law.curve.begin(), law.curve.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.x - row.v_mps) < std::abs(b.x - row.v_mps);
  });
  if (point != law.curve.end()) row.se_curve = point->se;
  row.shift_drag = config.drag == Effect::present ? shift_by_drag(row.v_mps, eps, config) : 0.0;
  row.shift_contact_time = config.contact_time == Effect::present ? shift_by_contact_time(row.v_mps, eps, config) : 0.0;
  if (config.travel_time == Effect::present)
    row.spread_travel_time = eps * config.kick_per_speed * row.v_mps / config.wave_speed_mps;
  add_shares(row);
  return row;
}

/// Power law through the spreads, by least squares in logarithms, weighted by counts; error from the rows' scatter
/// about it.
void fit_width(ErrorBudget& budget) {
  const std::vector<BudgetRow>& rows = budget.rows;
  if (rows.size() < 4) return;
  double w = 0.0, wx = 0.0, wy = 0.0;
  const auto y_of = [](const BudgetRow& r) { return log(r.spread); };
  for (const BudgetRow& r : rows) {
    if (!(r.spread > 0.0)) return;
    const auto n = static_cast<double>(r.n);
    w += n;
    wx += n * log(r.v_mps);
    wy += n * y_of(r);
  }
  double sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (const BudgetRow& r : rows) {
    const double x = log(r.v_mps) - wx / w, y = y_of(r) - wy / w, n = static_cast<double>(r.n);
    sxx += n * x * x;
    sxy += n * x * y;
    syy += n * y * y;
  }
  if (!(sxx > 0.0)) return;
  const double slope = sxy / sxx, n_free = static_cast<double>(rows.size()) - 2.0;
  const double se = std::sqrt(std::max(0.0, syy - slope * sxy) / n_free / sxx);
  Estimate exponent = normal_estimate(slope, se);
  const double reach68 = student_t_quantile(0.84135, n_free) * se, reach95 = student_t_quantile(0.975, n_free) * se;
  exponent.ci68 = Interval{slope - reach68, slope + reach68};
  exponent.ci95 = Interval{slope - reach95, slope + reach95};
  budget.width_exponent = exponent;
  for (const double v : {rows.front().v_mps, rows.back().v_mps})
    budget.width_law.push_back({v, exp(wy / w + slope * (log(v) - wx / w)), std::nullopt});
}

}  // namespace

BudgetConfig budget_config_of(const RestitutionSamples& samples, BudgetConfig base) {
  if (samples.empty()) return base;
  const SampleConditions& said = samples.front().conditions;
  const auto set = [](bool corrected, Effect& effect) {
    if (effect == Effect::present && corrected) effect = Effect::corrected;
  };
  set(said.drag_corrected, base.drag);
  set(said.contact_time_corrected, base.contact_time);
  set(said.travel_time_corrected, base.travel_time);
  base.wave_speed_mps = said.wave_speed_mps.value_or(base.wave_speed_mps);
  if (said.ball) base.ball = said.ball;
  if (said.plate) base.plate = said.plate;
  base.gravity_mps2 = said.gravity_mps2.value_or(base.gravity_mps2);
  return base;
}

ErrorBudget error_budget(const RestitutionSamples& samples, const LawFit& law, const BudgetConfig& config) {
  ErrorBudget budget;
  budget.ball = config.ball;
  budget.plate = config.plate;
  budget.effects = {
      {"air drag", config.drag}, {"contact time", config.contact_time}, {"travel time", config.travel_time}};
  if (!law.law || samples.empty()) return budget;
  const std::vector<double> residuals = residuals_from(*law.law, samples);
  budget.timing = timing_noise(samples, residuals);
  std::vector<BinMember> by_speed;
  by_speed.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) by_speed.push_back({samples[k].v_mps, &samples[k], residuals[k]});
  std::sort(by_speed.begin(), by_speed.end(), [](const auto& a, const auto& b) {
    return a.v_mps < b.v_mps || (a.v_mps == b.v_mps && a.sample < b.sample);
  });
  const std::size_t n = by_speed.size(), n_bins = std::clamp<std::size_t>(n / 12, 1, 12);
  for (std::size_t j = 0; j < n_bins; ++j)
    budget.rows.push_back(budget_row(std::span(by_speed).subspan(j * n / n_bins, (j + 1) * n / n_bins - j * n / n_bins),
                                     law, config, budget.timing));
  fit_width(budget);
  return budget;
}

}  // namespace bouncelab::fit
