// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/error_budget.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "bouncelab/core/numerics.hpp"
#include "law/law_model.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {

namespace {

/// Two neighbouring impacts of a drop.
struct ImpactPair {
  double product_s2;               ///< -r r' T T' / ((1+e)(1+e'))
  double normalised;               ///< r r' / (spread spread')
  double square;                   ///< of r / spread
  std::optional<double> stated_s;  ///< standard error of a time, by sigma_eps of the first
  std::size_t group;               ///< drop
};

std::vector<ImpactPair> pairs_of(const RestitutionSamples& samples, const std::vector<double>& residuals) {
  std::vector<ImpactPair> pairs;
  std::size_t drop = 0;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const RestitutionSample &a = samples[k], &b = samples[k + 1];
    if (a.recording != b.recording || a.drop != b.drop) {
      ++drop;
      continue;
    }
    const double interval_s = b.t_s - a.t_s;  // T_{i+1}
    if (b.impact != a.impact + 1 || !(interval_s > 0.0) || !(a.eps > 0.0)) continue;
    const double before_s = interval_s / a.eps;
    const double ra = residuals[k], rb = residuals[k + 1];
    std::optional<double> stated_s;
    if (a.sigma_eps) stated_s = *a.sigma_eps * before_s / std::sqrt(1.0 + square(1.0 + a.eps) + square(a.eps));
    // every spread of eps goes nearly as 1/T: that makes the pairs alike
    pairs.push_back({-ra * rb * interval_s * before_s / ((1.0 + a.eps) * (1.0 + b.eps)),
                     ra * before_s * rb * interval_s, square(ra * before_s), stated_s, drop});
  }
  return pairs;
}

struct MeanWithError {
  double mean, se;
};

/// Mean over pairs; error from the sums of the drops, or of pairs where there are few drops.
MeanWithError mean_by_drop(const std::vector<ImpactPair>& pairs, double ImpactPair::*member) {
  constexpr std::size_t kEnoughDrops = 8;
  const auto n = static_cast<double>(pairs.size());
  double mean = 0.0;
  for (const ImpactPair& p : pairs) mean += p.*member / n;
  const std::size_t n_drops = pairs.back().group + 1;
  const bool by_drop = n_drops >= kEnoughDrops;
  std::vector<double> sums(by_drop ? n_drops : pairs.size(), 0.0);
  for (std::size_t k = 0; k < pairs.size(); ++k) sums[by_drop ? pairs[k].group : k] += pairs[k].*member - mean;
  double variance = 0.0;
  for (const double s : sums) variance += s * s;
  return {mean, std::sqrt(variance) / n};
}

/// See TimingNoise. @param residuals  of the samples from the law  @return nullopt for fewer than 8 pairs of neighbours
/// with times
std::optional<TimingNoise> timing_noise(const RestitutionSamples& samples, const std::vector<double>& residuals) {
  const auto pairs = pairs_of(samples, residuals);
  if (pairs.size() < 8) return std::nullopt;
  const MeanWithError variance = mean_by_drop(pairs, &ImpactPair::product_s2);
  const MeanWithError covariance = mean_by_drop(pairs, &ImpactPair::normalised);
  double squares = 0.0;
  std::vector<double> stated_s;
  for (const ImpactPair& p : pairs) {
    squares += p.square / static_cast<double>(pairs.size());
    if (p.stated_s) stated_s.push_back(*p.stated_s);
  }
  TimingNoise noise;
  noise.n_pairs = pairs.size();
  noise.lag1_correlation = covariance.mean / squares;
  noise.lag1_correlation_se = covariance.se / squares;
  noise.variance_s2 = variance.mean;
  noise.variance_se_s2 = variance.se;
  if (variance.mean > 0.0) noise.sigma_s = std::sqrt(variance.mean);
  noise.upper95_s = std::sqrt(std::max(0.0, variance.mean) + 1.645 * variance.se);
  if (!stated_s.empty()) noise.stated_s = upper_median(std::move(stated_s));
  return noise;
}

/// What drag does to eps at a speed, uncorrected: two flights with the true eps between them.
std::optional<double> shift_by_drag(double v_mps, double eps, const BudgetConfig& config) {
  if (!config.ball) return std::nullopt;
  const double before_s = 2.0 * v_mps / config.gravity_mps2;
  const double g = config.gravity_mps2;
  const Flight before = flight_with_drag(before_s, g, drag_per_m(*config.ball, config.air, v_mps));
  const Flight after = flight_with_drag(eps * before_s, g, drag_per_m(*config.ball, config.air, eps * v_mps));
  return eps - after.launch_mps / before.landing_mps;
}

std::optional<double> shift_by_contact_time(double v_mps, double eps, const BudgetConfig& config) {
  if (!config.ball) return std::nullopt;
  const double before_s = 2.0 * v_mps / config.gravity_mps2;
  const auto contact = contact_duration(*config.ball, config.plate);
  if (!contact) return std::nullopt;
  return (eps * before_s + contact->at(v_mps)) / (before_s + contact->at(v_mps / eps)) - eps;
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

/// @param bin        indices of the samples, in order of speed
/// @param residuals  of the samples from the law
BudgetRow budget_row(std::span<const std::size_t> bin, const RestitutionSamples& samples,
                     const std::vector<double>& residuals, const LawFit& law, const BudgetConfig& config,
                     const std::optional<TimingNoise>& timing) {
  BudgetRow row;
  row.n = bin.size();
  const auto n = static_cast<double>(row.n);
  row.v_mps = samples[bin[bin.size() / 2]].v_mps;
  double squares = 0.0, stated = 0.0, n_stated = 0.0, mean = 0.0;
  for (const std::size_t k : bin) mean += residuals[k] / n;
  for (const std::size_t k : bin) {
    squares += square(residuals[k] - mean);
    if (!samples[k].sigma_eps) continue;
    stated += square(*samples[k].sigma_eps);
    n_stated += 1.0;
  }
  row.spread = std::sqrt(squares / std::max(1.0, n - 1.0));
  if (n_stated > 0.0) row.spread_timing_stated = std::sqrt(stated / n_stated);
  const double eps = restitution(*law.law, row.v_mps), interval_s = 2.0 * row.v_mps / config.gravity_mps2;
  if (timing && timing->sigma_s)
    row.spread_timing_lag1 = *timing->sigma_s * std::sqrt(1.0 + (1.0 + eps) * (1.0 + eps) + eps * eps) / interval_s;
  if (law.scatter) {
    const double below = law.scatter->below(row.v_mps), above = law.scatter->above(row.v_mps);
    row.spread_asperities = hypot(hypot(below, above), law.scatter->normal(row.v_mps));
    row.mean_minus_peak = law.scatter->mean_minus_peak(row.v_mps);
  }
  row.shift_drag = config.has_drag ? shift_by_drag(row.v_mps, eps, config) : 0.0;
  row.shift_contact_time = config.has_contact_time ? shift_by_contact_time(row.v_mps, eps, config) : 0.0;
  if (config.has_travel_time) row.spread_travel_time = eps * config.kick_per_speed * row.v_mps / config.wave_speed_mps;
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
  budget.width_exponent =
      normal_estimate(slope, se, student_t_quantile(0.84135, n_free), student_t_quantile(0.975, n_free));
  for (const double v : {rows.front().v_mps, rows.back().v_mps})
    budget.width_law.push_back({v, exp(wy / w + slope * (log(v) - wx / w)), std::nullopt});
}

}  // namespace

BudgetConfig budget_config_of(const RestitutionSamples& samples, BudgetConfig base) {
  if (samples.empty()) return base;
  const SampleConditions& said = samples.front().conditions;
  base.has_drag = base.has_drag && !said.drag_corrected;
  base.has_contact_time = base.has_contact_time && !said.contact_time_corrected && !said.of_heights;
  base.has_travel_time = base.has_travel_time && !said.travel_time_corrected && !said.of_heights;
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
  if (!law.law || samples.empty()) return budget;
  const std::vector<double> residuals = residuals_from(*law.law, samples);
  budget.timing = timing_noise(samples, residuals);
  const std::vector<std::size_t> rows = by_speed(samples);
  const std::size_t n = rows.size(), n_bins = std::clamp<std::size_t>(n / 12, 1, 12);
  for (std::size_t j = 0; j < n_bins; ++j)
    budget.rows.push_back(budget_row(std::span(rows).subspan(j * n / n_bins, (j + 1) * n / n_bins - j * n / n_bins),
                                     samples, residuals, law, config, budget.timing));
  fit_width(budget);
  return budget;
}

}  // namespace bouncelab::fit
