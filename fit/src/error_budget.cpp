// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/error_budget.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bouncelab {
namespace {

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Two neighbouring impacts of a drop.
struct Pair {
  double product_s2;  ///< -r r' T T' / ((1+e)(1+e'))
  double normalised;  ///< r r' / (spread spread')
  std::size_t group;  ///< drop
};

std::vector<Pair> pairs_of(const RestitutionSamples& samples, const LawFit& law) {
  std::vector<Pair> pairs;
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
    const double ra = a.eps - restitution(*law.law, a.v_mps), rb = b.eps - restitution(*law.law, b.v_mps);
    // every spread of eps goes nearly as 1/T: that makes the pairs alike
    pairs.push_back(
        {-ra * rb * interval_s * before_s / ((1.0 + a.eps) * (1.0 + b.eps)), ra * before_s * rb * interval_s, drop});
  }
  return pairs;
}

struct MeanWithError {
  double mean, se;
};

/// Mean over pairs; error from the sums of the drops, or of pairs where there are few drops.
MeanWithError mean_by_drop(const std::vector<Pair>& pairs, double Pair::*member) {
  constexpr std::size_t kEnoughDrops = 8;
  const auto n = static_cast<double>(pairs.size());
  double mean = 0.0;
  for (const Pair& p : pairs) mean += p.*member / n;
  const std::size_t n_drops = pairs.back().group + 1;
  const bool by_drop = n_drops >= kEnoughDrops;
  std::vector<double> sums(by_drop ? n_drops : pairs.size(), 0.0);
  for (std::size_t k = 0; k < pairs.size(); ++k) sums[by_drop ? pairs[k].group : k] += pairs[k].*member - mean;
  double variance = 0.0;
  for (const double s : sums) variance += s * s;
  return {mean, std::sqrt(variance) / n};
}

std::optional<double> stated_timing_s(const RestitutionSamples& samples) {
  std::vector<double> stated;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    const double interval_s = samples[k + 1].t_s - s.t_s;
    if (!s.sigma_eps || samples[k + 1].drop != s.drop || samples[k + 1].impact != s.impact + 1 || !(interval_s > 0.0))
      continue;
    const double of_times = std::sqrt(1.0 + (1.0 + s.eps) * (1.0 + s.eps) + s.eps * s.eps);
    stated.push_back(*s.sigma_eps * (interval_s / s.eps) / of_times);
  }
  if (stated.empty()) return std::nullopt;
  return median_of(stated);
}

std::optional<TimingNoise> timing_noise(const RestitutionSamples& samples, const LawFit& law) {
  const auto pairs = pairs_of(samples, law);
  if (pairs.size() < 8) return std::nullopt;
  const MeanWithError variance = mean_by_drop(pairs, &Pair::product_s2);
  const MeanWithError covariance = mean_by_drop(pairs, &Pair::normalised);
  double square = 0.0;
  std::size_t n = 0;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    const double interval_s = samples[k + 1].t_s - samples[k].t_s;
    if (samples[k + 1].drop != samples[k].drop || samples[k + 1].impact != samples[k].impact + 1 || !(interval_s > 0.0))
      continue;
    const double r = samples[k].eps - restitution(*law.law, samples[k].v_mps);
    square += std::pow(r * interval_s / samples[k].eps, 2);
    ++n;
  }
  TimingNoise noise;
  noise.n_pairs = pairs.size();
  noise.lag1_correlation = covariance.mean / (square / static_cast<double>(n));
  noise.lag1_correlation_se = covariance.se / (square / static_cast<double>(n));
  noise.variance_s2 = variance.mean;
  noise.variance_se_s2 = variance.se;
  if (variance.mean > 0.0) noise.sigma_s = std::sqrt(variance.mean);
  noise.upper95_s = std::sqrt(std::max(0.0, variance.mean) + 1.645 * variance.se);
  noise.stated_s = stated_timing_s(samples);
  return noise;
}

/// What drag and contact do to eps at a speed, uncorrected: two flights with the true eps between them.
void add_shifts(BudgetRow& row, const LawFit& law, const BudgetConfig& config) {
  const double eps = restitution(*law.law, row.v_mps), g = config.gravity_mps2;
  const double before_s = 2.0 * row.v_mps / g, after_s = eps * before_s;
  const Flight before = flight_with_drag(config.ball, config.air, before_s, g);
  const Flight after = flight_with_drag(config.ball, config.air, after_s, g);
  row.shift_drag = eps - after.launch_mps / before.landing_mps;
  const double contact_before_s = hertz_contact_time_s(config.ball, config.plate, row.v_mps / eps);
  const double contact_after_s = hertz_contact_time_s(config.ball, config.plate, row.v_mps);
  row.shift_contact_time = (after_s + contact_after_s) / (before_s + contact_before_s) - eps;
}

BudgetRow budget_row(std::vector<const RestitutionSample*> bin, const LawFit& law, const BudgetConfig& config,
                     const std::optional<TimingNoise>& timing) {
  BudgetRow row;
  row.n = bin.size();
  const auto n = static_cast<double>(row.n);
  row.v_mps = bin[bin.size() / 2]->v_mps;
  double square = 0.0, stated = 0.0, n_stated = 0.0, mean = 0.0;
  for (const RestitutionSample* s : bin) mean += (s->eps - restitution(*law.law, s->v_mps)) / n;
  for (const RestitutionSample* s : bin) {
    square += std::pow(s->eps - restitution(*law.law, s->v_mps) - mean, 2);
    if (!s->sigma_eps) continue;
    stated += *s->sigma_eps * *s->sigma_eps;
    n_stated += 1.0;
  }
  row.spread = std::sqrt(square / std::max(1.0, n - 1.0));
  if (n_stated > 0.0) row.spread_timing_stated = std::sqrt(stated / n_stated);
  const double eps = restitution(*law.law, row.v_mps), interval_s = 2.0 * row.v_mps / config.gravity_mps2;
  if (timing && timing->sigma_s)
    row.spread_timing_lag1 = *timing->sigma_s * std::sqrt(1.0 + (1.0 + eps) * (1.0 + eps) + eps * eps) / interval_s;
  if (law.scatter) {
    const double below = law.scatter->below(row.v_mps), above = law.scatter->above(row.v_mps);
    row.spread_asperities = law.method == LawMethod::least_squares ? below : std::hypot(below, above);
    row.mean_minus_peak = law.method == LawMethod::asymmetric_laplace ? above - below : 0.0;
  }
  const auto point = std::min_element(law.curve.begin(), law.curve.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.x - row.v_mps) < std::abs(b.x - row.v_mps);
  });
  if (point != law.curve.end() && point->band95) row.se_curve = (point->band95->hi - point->band95->lo) / (2.0 * 1.96);
  add_shifts(row, law, config);
  return row;
}

/// Slope of log spread_asperities (or of the total spread) against log v, weighted by counts.
std::optional<Estimate> width_exponent(const std::vector<BudgetRow>& rows) {
  if (rows.size() < 4) return std::nullopt;
  double w = 0.0, wx = 0.0, wy = 0.0;
  const auto y_of = [](const BudgetRow& r) { return std::log(r.spread); };
  for (const BudgetRow& r : rows) {
    if (!(r.spread > 0.0)) return std::nullopt;
    const auto n = static_cast<double>(r.n);
    w += n;
    wx += n * std::log(r.v_mps);
    wy += n * y_of(r);
  }
  double sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (const BudgetRow& r : rows) {
    const double x = std::log(r.v_mps) - wx / w, y = y_of(r) - wy / w, n = static_cast<double>(r.n);
    sxx += n * x * x;
    sxy += n * x * y;
    syy += n * y * y;
  }
  if (!(sxx > 0.0)) return std::nullopt;
  const double slope = sxy / sxx;
  const double residual = std::max(0.0, syy - slope * sxy) / (static_cast<double>(rows.size()) - 2.0);
  return normal_estimate(slope, std::sqrt(residual / sxx));
}

}  // namespace

ErrorBudget error_budget(const RestitutionSamples& samples, const LawFit& law, const BudgetConfig& config) {
  ErrorBudget budget;
  if (!law.law || samples.empty()) return budget;
  budget.timing = timing_noise(samples, law);
  std::vector<const RestitutionSample*> by_speed;
  for (const RestitutionSample& s : samples) by_speed.push_back(&s);
  std::sort(by_speed.begin(), by_speed.end(), [](const auto* a, const auto* b) { return a->v_mps < b->v_mps; });
  const std::size_t n = by_speed.size(), n_bins = std::clamp<std::size_t>(n / 12, 1, 12);
  for (std::size_t j = 0; j < n_bins; ++j)
    budget.rows.push_back(budget_row({by_speed.begin() + static_cast<std::ptrdiff_t>(j * n / n_bins),
                                      by_speed.begin() + static_cast<std::ptrdiff_t>((j + 1) * n / n_bins)},
                                     law, config, budget.timing));
  budget.width_exponent = width_exponent(budget.rows);
  return budget;
}

}  // namespace bouncelab
