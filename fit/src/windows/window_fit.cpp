// SPDX-License-Identifier: GPL-3.0-or-later
#include "windows/window_fit.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "law/intervals.hpp"
#include "law/law_search.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

/// Estimate of value whose error is that of sign * log(value): intervals are not symmetric.
Estimate exponential_estimate(double log_value, const QuantityError& error, double sign) {
  const double value = exp(log_value);
  Estimate e = normal_estimate(value, value * error.se);
  if (error.se_independent) e.se_independent = value * *error.se_independent;
  const auto through = [&](const Interval& offset) {
    const double a = value * exp(sign * offset.lo), b = value * exp(sign * offset.hi);
    return Interval{std::min(a, b), std::max(a, b)};
  };
  e.ci68 = through(error.offset68);
  e.ci95 = through(error.offset95);
  return e;
}

/// Of direction . theta.
QuantityError quantity_error(const LogLikelihood& function, const WindowFit& fit, const Eigen::MatrixXd& white,
                             const std::optional<ErrorsByDrop>& by_drop, const Eigen::VectorXd& direction) {
  QuantityError error;
  error.se = transposed_product(white, direction).norm();
  ProfileLevels reach, levels;
  if (by_drop) {
    error.se_independent = error.se;
    error.se = by_drop->standard_error(direction);
    reach = by_drop->reach();
    levels = by_drop->profile_levels_of(direction, white);
  }
  error.offset68 = {-reach.z68 * error.se, reach.z68 * error.se};
  error.offset95 = {-reach.z95 * error.se, reach.z95 * error.se};
  if (!fit.maximum.converged) return error;
  const Eigen::MatrixXd* const curvature = by_drop ? &by_drop->curvature : nullptr;
  if (const auto profile = profile_intervals(function, fit.maximum, white, direction, levels, curvature)) {
    error.offset68 = profile->offset68;
    error.offset95 = profile->offset95;
  }
  return error;
}

}  // namespace

WindowFit fit_window(const LawData& original, ScatterKind kind) {
  const LawModel constant = make_law_model(LawKind::constant, {}, original.v_mps);
  const ScatterFamily family{kind, 1, original.v_mps.front()};
  LawData data = original;
  const Eigen::VectorXd start = start_values(original, constant, family);
  if (kind != ScatterKind::normal)
    widen(data, scatter_model_of(start, constant.n_parameters(), family),
          1.0 / std::sqrt(static_cast<double>(original.size())));
  const LawLikelihood likelihood(data, constant, family);
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  WindowFit fit{kind, maximise(function, start, likelihood.information(start)), {}, {}, {}};
  const Eigen::MatrixXd white = whitening(likelihood.information(fit.maximum.x), 1e-10);
  fit.se = gram(white).diagonal().cwiseSqrt();
  if (kind != ScatterKind::asymmetric_laplace) return fit;
  const auto by_drop = errors_by_drop(likelihood, fit.maximum.x, white);
  fit.drops = {likelihood.n_drops(), by_drop ? ErrorBasis::by_drop : ErrorBasis::independent_samples};
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 1, -1)})
    fit.errors.push_back(quantity_error(function, fit, white, by_drop, direction));
  return fit;
}

Estimate peak_estimate(const WindowFit& fit) {
  const QuantityError& error = fit.errors[0];
  Estimate e = normal_estimate(fit.maximum.x[0], error.se);
  e.se_independent = error.se_independent;
  e.ci68 = {e.value + error.offset68.lo, e.value + error.offset68.hi};
  e.ci95 = {e.value + error.offset95.lo, e.value + error.offset95.hi};
  return e;
}

Estimate slope_estimate(const WindowFit& fit, Eigen::Index side) {
  constexpr double kKnownToAFactor2 = 0.35;  // standard error of log b
  const QuantityError& error = fit.errors[static_cast<std::size_t>(side)];
  Estimate e = exponential_estimate(-fit.maximum.x[side], error, -1.0);
  // where the prior on the ratio of the sides decides, drops agree with each other
  e.identified = std::max(error.se, error.se_independent.value_or(0.0)) < kKnownToAFactor2;
  return e;
}

Estimate slope_ratio_estimate(const WindowFit& fit) {
  return exponential_estimate(fit.maximum.x[1] - fit.maximum.x[2], fit.errors[3], 1.0);
}

std::vector<double> probabilities_below(const LawData& data, const WindowFit& fit) {
  const LawModel constant = make_law_model(LawKind::constant, {}, data.v_mps);
  const ScatterFamily family{fit.kind, 1, data.v_mps.front()};
  return LawLikelihood(data, constant, family).probabilities_below(fit.maximum.x);
}

std::vector<CurvePoint> density_curve(const LawData& data, const WindowFit& fit, const Bins& bins) {
  const Eigen::VectorXd& theta = fit.maximum.x;
  const bool is_normal = fit.kind == ScatterKind::normal;
  constexpr std::size_t kMostBins = 80;  // 161 points or more, so that the picture is smooth
  const std::size_t n_bins = bins.counts.size(),
                    n_points = 1 + 2 * n_bins * std::max<std::size_t>(1, kMostBins / n_bins);
  std::vector<double> sorted = data.tau;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n_taus = std::min(kBlockSize, sorted.size());
  SidesBlock sides;
  sides.fill(exp(theta[1]), exp(theta[is_normal ? 1 : 2]));
  Block tau, inverse_tau;
  for (std::size_t j = 0; j < n_taus; ++j) {
    tau[j] = sorted[(2 * j + 1) * sorted.size() / (2 * n_taus)];
    inverse_tau[j] = 1.0 / tau[j];
  }
  std::vector<CurvePoint> curve;
  for (std::size_t k = 0; k < n_points; ++k) {
    const double eps = bins.eps_edges.front() + (bins.eps_edges.back() - bins.eps_edges.front()) *
                                                    static_cast<double>(k) / static_cast<double>(n_points - 1);
    double sum = 0.0;
    if (is_normal) {
      for (std::size_t j = 0; j < n_taus; ++j) {
        const double variance = square(exp(theta[1])) + square(tau[j]);
        sum += exp(-0.5 * square(eps - theta[0]) / variance) / std::sqrt(2.0 * kPi * variance);
      }
    } else {
      Block d;
      d.fill(eps - theta[0]);
      DensityBlock f;
      normal_laplace(n_taus, d.data(), sides, tau.data(), inverse_tau.data(), 0.0, f);
      for (std::size_t j = 0; j < n_taus; ++j) sum += f.factor[j] * exp(f.exponent[j]);
    }
    curve.push_back({eps, sum / static_cast<double>(n_taus), std::nullopt});
  }
  return curve;
}

}  // namespace bouncelab::fit
