// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/histogram_fit.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/error.hpp"
#include "goodness.hpp"
#include "law_likelihood.hpp"
#include "maximise.hpp"
#include "profile.hpp"
#include "start_values.hpp"

namespace bouncelab {
namespace {

constexpr double kResolution = 1e-8;  // of eps, as in the law's fit

/// Samples of the window, moved along the law to its centre.
LawData window_data(const RestitutionSamples& samples, double lo, double hi, double centre, const LawFit& law) {
  LawData data;
  const double eps_centre = law.law ? restitution(*law.law, centre) : 0.0;
  for (const RestitutionSample& s : samples) {
    if (!(s.v_mps >= lo && s.v_mps < hi) || !std::isfinite(s.eps)) continue;
    double eps = s.eps, tau = std::hypot(s.sigma_eps.value_or(0.0), kResolution);
    if (law.law) {
      const double residual = eps - restitution(*law.law, s.v_mps);
      const double stretch = !law.scatter     ? 1.0
                             : residual > 0.0 ? law.scatter->above(centre) / law.scatter->above(s.v_mps)
                                              : law.scatter->below(centre) / law.scatter->below(s.v_mps);
      eps = eps_centre + residual * stretch;
      tau *= stretch;
    }
    data.v_mps.push_back(centre);
    data.eps.push_back(eps);
    data.tau.push_back(tau);
    data.drop.push_back(0);
  }
  return data;
}

Bins bins_of(std::vector<double> eps) {
  std::sort(eps.begin(), eps.end());
  const std::size_t n = eps.size();
  const double lo_quantile = eps[n / 200], hi_quantile = eps[n - 1 - n / 200];
  const double margin = std::max(0.15 * (hi_quantile - lo_quantile), 1e-9);
  const double lo = lo_quantile - margin, hi = hi_quantile + margin;
  const auto n_bins = std::clamp<std::size_t>(static_cast<std::size_t>(1.5 * std::sqrt(static_cast<double>(n))), 8, 80);
  Bins bins;
  for (std::size_t k = 0; k <= n_bins; ++k)
    bins.eps_edges.push_back(lo + (hi - lo) * static_cast<double>(k) / static_cast<double>(n_bins));
  bins.counts.assign(n_bins, 0);
  for (const double e : eps) {
    if (e < lo) {
      ++bins.underflow;
    } else if (e >= hi) {
      ++bins.overflow;
    } else {
      const auto k = static_cast<std::size_t>((e - lo) / (hi - lo) * static_cast<double>(n_bins));
      ++bins.counts[std::min(k, n_bins - 1)];
    }
  }
  return bins;
}

/// The density expected of the window's samples: the mean over their timing errors.
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
      sum += std::exp(normal_laplace(eps - theta[0], std::exp(theta[1]), std::exp(theta[2]),
                                     taus[(2 * j + 1) * taus.size() / (2 * n_taus)])
                          .log_density);
    curve.push_back({eps, sum / static_cast<double>(n_taus), std::nullopt});
  }
  return curve;
}

struct WindowFit {
  LawData data;
  Maximum maximum;
  Eigen::MatrixXd covariance;
  std::vector<std::optional<ProfileIntervals>> profiles;  ///< of peak, log b_below, log b_above
};

WindowFit fit_window(const LawData& original, ScatterKind kind) {
  const LawModel constant = make_law_model(LawKind::constant, {}, original.v_mps);
  const ScatterFamily family{kind, 1, original.v_mps.front()};
  WindowFit fit{original, {}, {}, {}};
  const Eigen::VectorXd start = start_values(original, constant, family);
  if (kind != ScatterKind::normal)
    widen(fit.data, LawLikelihood(original, constant, family), start,
          1.0 / std::sqrt(static_cast<double>(original.size())));
  const LawLikelihood likelihood(fit.data, constant, family);
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  fit.maximum = maximise(function, start, likelihood.information(start));
  const Eigen::MatrixXd white = whitening(likelihood.information(fit.maximum.x), 1e-10);
  fit.covariance = white * white.transpose();
  if (kind == ScatterKind::asymmetric_laplace && fit.maximum.converged)
    for (Eigen::Index i = 0; i < start.size(); ++i)
      fit.profiles.push_back(profile_intervals(function, fit.maximum, white, Eigen::VectorXd::Unit(start.size(), i)));
  return fit;
}

/// Intervals about `value` at the offsets given, through a monotone function.
void set_intervals(Estimate& e, const Interval& offset68, const Interval& offset95, auto&& value_of) {
  const auto ordered = [&](const Interval& i) {
    const double a = value_of(i.lo), b = value_of(i.hi);
    return Interval{std::min(a, b), std::max(a, b)};
  };
  e.ci68 = ordered(offset68);
  e.ci95 = ordered(offset95);
}

Estimate peak_estimate(const WindowFit& fit) {
  Estimate e = normal_estimate(fit.maximum.x[0], std::sqrt(fit.covariance(0, 0)));
  if (fit.profiles.empty() || !fit.profiles[0]) return e;
  const auto at = [&](double offset) { return e.value + offset; };
  set_intervals(e, fit.profiles[0]->offset68, fit.profiles[0]->offset95, at);
  e.interval_method = "profile";
  return e;
}

/// 1/b from log b, i = 1 below, 2 above: intervals are those of the logarithm.
Estimate slope_estimate(const WindowFit& fit, Eigen::Index i) {
  constexpr double k95 = 1.959963984540054;
  constexpr double kKnownToAFactor2 = 0.35;  // standard error of log b
  const double se = std::sqrt(fit.covariance(i, i)), slope = std::exp(-fit.maximum.x[i]);
  Estimate e = normal_estimate(slope, slope * se);
  const auto& profile = fit.profiles.empty() ? std::nullopt : fit.profiles[static_cast<std::size_t>(i)];
  const auto at = [&](double offset) { return slope * std::exp(-offset); };
  set_intervals(e, profile ? profile->offset68 : Interval{-se, se},
                profile ? profile->offset95 : Interval{-k95 * se, k95 * se}, at);
  if (profile) e.interval_method = "profile";
  e.identified = se < kKnownToAFactor2;
  return e;
}

void describe(HistogramFit& result, const LawData& data) {
  const WindowFit fit = fit_window(data, ScatterKind::asymmetric_laplace);
  const Eigen::VectorXd& theta = fit.maximum.x;
  result.status = fit.maximum.converged ? FitStatus::ok : FitStatus::not_converged;
  if (!fit.maximum.converged) result.message = "the search did not converge";
  result.peak_eps = peak_estimate(fit);
  result.slope_rising = slope_estimate(fit, 1);
  result.slope_falling = slope_estimate(fit, 2);
  if (!result.slope_rising->identified || !result.slope_falling->identified) {
    if (fit.maximum.converged) result.status = FitStatus::not_identifiable;
    result.message = "the scatter is narrower than the timing error: its slopes are not identifiable";
  }
  result.loglik = fit.maximum.loglik;
  std::vector<double> u;
  for (std::size_t k = 0; k < data.size(); ++k)
    u.push_back(normal_laplace_cdf(data.eps[k] - theta[0], std::exp(theta[1]), std::exp(theta[2]), data.tau[k]));
  if (const auto chi2 = pearson_chi2(u, 3)) {
    result.chi2 = chi2->chi2;
    result.ndf = chi2->ndf;
    result.p_value = chi2->p_value;
  }
  const WindowFit normal = fit_window(data, ScatterKind::normal);
  if (normal.maximum.converged && fit.maximum.converged)
    result.delta_aic_gaussian = 2.0 * (2.0 - normal.maximum.loglik) - 2.0 * (3.0 - fit.maximum.loglik);
  result.curve = density_curve(data, theta, result.bins);
}

}  // namespace

std::vector<HistogramFit> fit_histograms(const RestitutionSamples& samples, const HistogramConfig& config,
                                         const LawFit& law) {
  if (!(config.width_mps > 0.0))
    throw InvalidArgument("width of the histograms' windows " + std::to_string(config.width_mps) +
                          " m/s: must be positive");
  std::vector<HistogramFit> results;
  for (const double centre : config.centres_mps) {
    HistogramFit result;
    result.v_mps = centre;
    result.v_lo_mps = centre - 0.5 * config.width_mps;
    result.v_hi_mps = centre + 0.5 * config.width_mps;
    if (!(centre > 0.0))
      throw InvalidArgument("centre of a histogram's window " + std::to_string(centre) + " m/s: must be positive");
    const LawData data = window_data(samples, result.v_lo_mps, result.v_hi_mps, centre, law);
    result.n = data.size();
    if (result.n > 0) result.bins = bins_of(data.eps);
    if (result.n < std::max<std::size_t>(config.n_min, 5))
      result.message = std::to_string(result.n) + " samples: at least " + std::to_string(config.n_min) + " are needed";
    else
      describe(result, data);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace bouncelab
