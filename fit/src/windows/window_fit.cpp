// SPDX-License-Identifier: GPL-3.0-or-later
#include "windows/window_fit.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "law/start_values.hpp"

namespace bouncelab::fit {
namespace {

constexpr double k95 = 1.959963984540054;

/// Estimate of sign * exp(log_value) whose logarithm has this standard error, or these profile intervals.
Estimate exponential_estimate(double log_value, double se, const std::optional<ProfileIntervals>& profile,
                              double sign) {
  const double value = exp(log_value);
  Estimate e = normal_estimate(value, value * se);
  const auto through = [&](const Interval& offset) {
    const double a = value * exp(sign * offset.lo), b = value * exp(sign * offset.hi);
    return Interval{std::min(a, b), std::max(a, b)};
  };
  e.ci68 = through(profile ? profile->offset68 : Interval{-se, se});
  e.ci95 = through(profile ? profile->offset95 : Interval{-k95 * se, k95 * se});
  if (profile) e.interval_method = IntervalMethod::profile;
  return e;
}

std::optional<ProfileIntervals> profile_of(const WindowFit& fit, std::size_t i) {
  return fit.profiles.empty() ? std::nullopt : fit.profiles[i];
}

}  // namespace

WindowFit fit_window(const LawData& original, ScatterKind kind) {
  const LawModel constant = make_law_model(LawKind::constant, {}, original.v_mps);
  const ScatterFamily family{kind, 1, original.v_mps.front()};
  LawData data = original;
  const Eigen::VectorXd start = start_values(original, constant, family);
  if (kind != ScatterKind::normal)
    widen(data, LawLikelihood(original, constant, family), start,
          1.0 / std::sqrt(static_cast<double>(original.size())));
  const LawLikelihood likelihood(data, constant, family);
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  WindowFit fit;
  fit.maximum = maximise(function, start, likelihood.information(start));
  const Eigen::MatrixXd white = whitening(likelihood.information(fit.maximum.x), 1e-10);
  fit.covariance = white * white.transpose();
  if (kind != ScatterKind::asymmetric_laplace || !fit.maximum.converged) return fit;
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 1, -1)})
    fit.profiles.push_back(profile_intervals(function, fit.maximum, white, direction));
  return fit;
}

Estimate peak_estimate(const WindowFit& fit) {
  Estimate e = normal_estimate(fit.maximum.x[0], std::sqrt(fit.covariance(0, 0)));
  if (const auto profile = profile_of(fit, 0)) {
    e.ci68 = {e.value + profile->offset68.lo, e.value + profile->offset68.hi};
    e.ci95 = {e.value + profile->offset95.lo, e.value + profile->offset95.hi};
    e.interval_method = IntervalMethod::profile;
  }
  return e;
}

Estimate slope_estimate(const WindowFit& fit, Eigen::Index side) {
  constexpr double kKnownToAFactor2 = 0.35;  // standard error of log b
  const double se = std::sqrt(fit.covariance(side, side));
  Estimate e = exponential_estimate(-fit.maximum.x[side], se, profile_of(fit, static_cast<std::size_t>(side)), -1.0);
  e.identified = se < kKnownToAFactor2;
  return e;
}

Estimate slope_ratio_estimate(const WindowFit& fit) {
  const Eigen::MatrixXd& c = fit.covariance;
  const double se = std::sqrt(c(1, 1) + c(2, 2) - 2.0 * c(1, 2));
  return exponential_estimate(fit.maximum.x[1] - fit.maximum.x[2], se, profile_of(fit, 3), 1.0);
}

std::vector<CurvePoint> density_curve(const LawData& data, const Eigen::VectorXd& theta, const Bins& bins) {
  constexpr std::size_t kPoints = 161, kTaus = 64;
  std::vector<double> taus = data.tau;
  std::sort(taus.begin(), taus.end());
  const std::size_t n_taus = std::min(kTaus, taus.size());
  std::vector<CurvePoint> curve;
  for (std::size_t k = 0; k < kPoints; ++k) {
    const double eps = bins.eps_edges.front() +
                       (bins.eps_edges.back() - bins.eps_edges.front()) * static_cast<double>(k) / (kPoints - 1);
    double sum = 0.0;
    for (std::size_t j = 0; j < n_taus; ++j)
      sum += exp(
          normal_laplace(eps - theta[0], exp(theta[1]), exp(theta[2]), taus[(2 * j + 1) * taus.size() / (2 * n_taus)])
              .log_density);
    curve.push_back({eps, sum / static_cast<double>(n_taus), std::nullopt});
  }
  return curve;
}

}  // namespace bouncelab::fit
