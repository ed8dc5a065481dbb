// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/histogram_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/goodness.hpp"
#include "law/intervals.hpp"
#include "law/law_likelihood.hpp"
#include "law/law_model.hpp"
#include "law/law_search.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// Two exponentials for all samples of a window, unbinned: theta = (location, log b_below, log b_above).
struct WindowFit {
  Maximum maximum;
  std::vector<double> probabilities_below;  ///< of each sample, with its own timing error
  DropCount drops;
  /// By drop where there are enough drops, the law by which samples were moved to the centre taken as known.
  Estimate peak, log_below, log_above, log_ratio;
};

ScatterFamily exponentials_of(const LawData& data) {
  return {.has_normal_part = false, .n_terms = 1, .v_ref_mps = data.v_mps.front()};
}

/// exp(sign ln) of an estimate of ln.
Estimate exponential(const Estimate& ln, double sign) {
  Estimate e = ln;
  e.value = exp(sign * ln.value);
  for (std::optional<double>* se : {&e.se, &e.se_independent})
    if (*se) **se *= e.value;
  for (std::optional<Interval>* interval : {&e.ci68, &e.ci95}) {
    const double a = exp(sign * (*interval)->lo), b = exp(sign * (*interval)->hi);
    *interval = Interval{std::min(a, b), std::max(a, b)};
  }
  return e;
}

/// Of direction . theta.
Estimate quantity(const LogLikelihood& function, const Maximum& maximum, const Eigen::MatrixXd& white,
                  const std::optional<JackknifeErrors>& by_drop, const Eigen::VectorXd& direction) {
  const double value = direction.dot(maximum.x), se_independent = transposed_product(white, direction).norm();
  ProfileLevels reach, levels;
  if (by_drop) {
    reach = by_drop->reach();
    levels = by_drop->profile_levels_of(direction, white);
  }
  Estimate e =
      normal_estimate(value, by_drop ? by_drop->standard_error(direction) : se_independent, reach.z68, reach.z95);
  if (by_drop) e.se_independent = se_independent;
  if (!maximum.converged) return e;
  const Eigen::MatrixXd* const curvature = by_drop ? &by_drop->curvature : nullptr;
  if (const auto profile = profile_intervals(function, maximum, white, direction, levels, curvature)) {
    e.ci68 = {value + profile->offset68.lo, value + profile->offset68.hi};
    e.ci95 = {value + profile->offset95.lo, value + profile->offset95.hi};
  }
  return e;
}

/// @param data  at least 5 samples
WindowFit fit_window(const LawData& original, const LawModel& constant, const Eigen::VectorXd& start) {
  const ScatterFamily family = exponentials_of(original);
  LawData data = original;
  widen(data, scatter_model_of(start, constant.n_parameters(), family),
        1.0 / std::sqrt(static_cast<double>(original.size())));
  const LawLikelihood likelihood(data, constant, family);
  WindowFit fit;
  fit.maximum = maximise(std::cref(likelihood), start, likelihood.information(start));
  fit.probabilities_below = LawLikelihood(original, constant, family).probabilities_below(fit.maximum.x);
  const Eigen::MatrixXd white = whitening(likelihood.information(fit.maximum.x), 1e-10);
  const auto by_drop = errors_by_drop(likelihood, fit.maximum.x, white);
  fit.drops = {likelihood.n_drops(), by_drop ? ErrorBasis::by_drop : ErrorBasis::independent_samples};
  const auto of = [&](double location, double below, double above) {
    return quantity(std::cref(likelihood), fit.maximum, white, by_drop, Eigen::Vector3d(location, below, above));
  };
  fit.peak = of(1, 0, 0);
  fit.log_below = of(0, 1, 0);
  fit.log_above = of(0, 0, 1);
  fit.log_ratio = of(0, 1, -1);
  return fit;
}

/// @param log_b  of one side
Estimate slope_estimate(const Estimate& log_b) {
  constexpr double kKnownToAFactor2 = 0.35;  // standard error of log b
  Estimate e = exponential(log_b, -1.0);
  // where the prior on the ratio of the sides decides, drops agree with each other
  e.identified = std::max(*log_b.se, log_b.se_independent.value_or(0.0)) < kKnownToAFactor2;
  return e;
}

/// Normal scatter of a window, with each sample's timing error: theta = (mean, log sd).
struct NormalWindow {
  Maximum maximum;
  Eigen::VectorXd se;
};
NormalWindow fit_normal(const LawData& data, const Eigen::VectorXd& start) {
  const auto variance_of = [&](const Eigen::VectorXd& x, std::size_t k) {
    return exp(2.0 * x[1]) + square(data.tau[k]);
  };
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
    double sum = 0.0, by_mean = 0.0, by_log_sd = 0.0;
    for (std::size_t k = 0; k < data.size(); ++k) {
      const double variance = variance_of(x, k), d = data.eps[k] - x[0], ratio = d * d / variance;
      sum -= 0.5 * (ratio + log(2.0 * kPi * variance));
      by_mean += d / variance;
      by_log_sd += (ratio - 1.0) * exp(2.0 * x[1]) / variance;
    }
    if (gradient) *gradient = Eigen::Vector2d(by_mean, by_log_sd);
    return sum;
  };
  const auto information = [&](const Eigen::VectorXd& x) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < data.size(); ++k)
      sum += Eigen::Vector2d(1.0 / variance_of(x, k), 2.0 * square(exp(2.0 * x[1]) / variance_of(x, k)));
    return sum;
  };
  NormalWindow fit{maximise(function, start, information(start).asDiagonal()), {}};
  fit.se = information(fit.maximum.x).cwiseSqrt().cwiseInverse();
  return fit;
}

/// The density expected of the window's samples, the mean of `of` over their timing errors, from the first edge to the
/// last: each edge is a point, and between two lie an odd number, so that the middle of each bin is one.
/// @param of  (eps, timing errors) sum of the densities
template <class Of>
std::vector<CurvePoint> density_curve(const LawData& data, const Bins& bins, Of of) {
  constexpr std::size_t kMostBins = 80;  // 161 points or more, so that the picture is smooth
  const std::size_t n_bins = bins.counts.size(),
                    n_points = 1 + 2 * n_bins * std::max<std::size_t>(1, kMostBins / n_bins);
  std::vector<double> sorted = data.tau, taus;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n_taus = std::min(kBlockSize, sorted.size());
  for (std::size_t j = 0; j < n_taus; ++j) taus.push_back(sorted[(2 * j + 1) * sorted.size() / (2 * n_taus)]);
  std::vector<CurvePoint> curve;
  for (std::size_t k = 0; k < n_points; ++k) {
    const double eps = bins.eps_edges.front() + (bins.eps_edges.back() - bins.eps_edges.front()) *
                                                    static_cast<double>(k) / static_cast<double>(n_points - 1);
    curve.push_back({eps, of(eps, taus) / static_cast<double>(n_taus), std::nullopt});
  }
  return curve;
}

std::vector<CurvePoint> exponentials_curve(const LawData& data, const Eigen::VectorXd& theta, const Bins& bins) {
  SidesBlock sides;
  sides.fill(exp(theta[1]), exp(theta[2]));
  return density_curve(data, bins, [&](double eps, const std::vector<double>& taus) {
    Block d, inverse_tau;
    d.fill(eps - theta[0]);
    for (std::size_t j = 0; j < taus.size(); ++j) inverse_tau[j] = 1.0 / taus[j];
    DensityBlock f;
    normal_laplace(taus.size(), d.data(), sides, taus.data(), inverse_tau.data(), 0.0, f);
    double sum = 0.0;
    for (std::size_t j = 0; j < taus.size(); ++j) sum += f.factor[j] * exp(f.exponent[j]);
    return sum;
  });
}

std::vector<CurvePoint> normal_curve(const LawData& data, const Eigen::VectorXd& theta, const Bins& bins) {
  return density_curve(data, bins, [&](double eps, const std::vector<double>& taus) {
    double sum = 0.0;
    for (const double tau : taus) {
      const double variance = exp(2.0 * theta[1]) + square(tau);
      sum += exp(-0.5 * square(eps - theta[0]) / variance) / std::sqrt(2.0 * kPi * variance);
    }
    return sum;
  });
}

/// Residuals of the samples at the window's centre, stretched as the scatter is there.
void move_to(double centre, const LawFit& law, LawData& data) {
  const double eps_centre = restitution(*law.law, centre);
  for (std::size_t k = 0; k < data.size(); ++k) {
    const double v_mps = data.v_mps[k], residual = data.eps[k] - restitution(*law.law, v_mps);
    const auto b = residual > 0.0 ? &ScatterModel::above : &ScatterModel::below;
    const double stretch = law.scatter ? (*law.scatter.*b)(centre) / (*law.scatter.*b)(v_mps) : 1.0;
    data.eps[k] = eps_centre + residual * stretch;
    data.tau[k] *= stretch;
  }
}

/// Samples of the window, moved along the law to its centre.
/// @param v_mps  their speeds: a sample is some hundred bytes, and each window has few of them
LawData window_data(const RestitutionSamples& samples, const std::vector<double>& v_mps, double lo, double hi,
                    double centre, const LawFit& law) {
  LawData data;
  DropNumbers drops;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!(v_mps[k] >= lo && v_mps[k] < hi)) continue;
    const RestitutionSample& s = samples[k];
    if (!std::isfinite(s.eps)) continue;
    data.v_mps.push_back(s.v_mps);
    data.eps.push_back(s.eps);
    data.tau.push_back(hypot(s.sigma_eps.value_or(0.0), kResolution));
    data.drop.push_back(drops.of(s));
  }
  if (law.law) move_to(centre, law, data);
  std::fill(data.v_mps.begin(), data.v_mps.end(), centre);
  return data;
}

std::vector<double> even_edges(double lo, double hi, std::size_t n) {
  std::vector<double> edges;
  for (std::size_t k = 0; k <= n; ++k)
    edges.push_back(lo + (hi - lo) * static_cast<double>(k) / static_cast<double>(n));
  return edges;
}

std::size_t bin_of(double x, const std::vector<double>& edges) {
  const double fraction = (x - edges.front()) / (edges.back() - edges.front());
  const auto n = edges.size() - 1;
  return std::min(static_cast<std::size_t>(fraction * static_cast<double>(n)), n - 1);
}

Bins bins_of(std::vector<double> eps) {
  std::sort(eps.begin(), eps.end());
  const std::size_t n = eps.size();
  const double lo_quantile = eps[n / 200], hi_quantile = eps[n - 1 - n / 200];
  const double margin = std::max(0.15 * (hi_quantile - lo_quantile), 1e-9);
  const double lo = lo_quantile - margin, hi = hi_quantile + margin;
  const auto n_bins = std::clamp<std::size_t>(static_cast<std::size_t>(1.5 * std::sqrt(static_cast<double>(n))), 8, 80);
  Bins bins;
  bins.eps_edges = even_edges(lo, hi, n_bins);
  bins.counts.assign(n_bins, 0);
  for (const double e : eps)
    if (e < lo)
      ++bins.underflow;
    else if (e >= hi)
      ++bins.overflow;
    else
      ++bins.counts[bin_of(e, bins.eps_edges)];
  return bins;
}

/// Mean of a density over the k-th bin, by trapezoids.
double mean_in_bin(const std::vector<CurvePoint>& density, std::size_t n_bins, std::size_t k) {
  const std::size_t n = (density.size() - 1) / n_bins;
  double sum = 0.5 * (density[k * n].y + density[(k + 1) * n].y);
  for (std::size_t j = 1; j < n; ++j) sum += density[k * n + j].y;
  return sum / static_cast<double>(n);
}

void fit_two_exponentials(HistogramFit& result, const LawData& data, const WindowFit& fit) {
  result.status = fit.maximum.converged ? FitStatus::ok : FitStatus::not_converged;
  result.drops = fit.drops;
  result.peak_eps = fit.peak;
  result.slope_rising = slope_estimate(fit.log_below);
  result.slope_falling = slope_estimate(fit.log_above);
  result.slope_ratio = exponential(fit.log_ratio, 1.0);
  if ((!result.slope_rising->identified || !result.slope_falling->identified) && fit.maximum.converged)
    result.status = FitStatus::not_identifiable;  // the scatter is narrower than the timing error
  result.loglik = fit.maximum.loglik;
  result.curve = exponentials_curve(data, fit.maximum.x, result.bins);
  result.pearson = pearson_chi2(fit.probabilities_below, 3, 1);
}

/// @param start  (mean, log sd)
void compare_with_normal(HistogramFit& result, const LawData& data, const Eigen::VectorXd& start) {
  const NormalWindow fit = fit_normal(data, start);
  if (!fit.maximum.converged) return;
  const double mean = fit.maximum.x[0], sd = exp(fit.maximum.x[1]);
  NormalFit& normal = result.normal.emplace();
  normal.mean = normal_estimate(mean, fit.se[0]);
  normal.sd = normal_estimate(sd, sd * fit.se[1]);
  normal.delta_aic = 2.0 * (2.0 - fit.maximum.loglik) - 2.0 * (3.0 - *result.loglik);
  std::vector<double> below;
  for (std::size_t k = 0; k < data.size(); ++k) below.push_back((data.eps[k] - mean) / hypot(sd, data.tau[k]));
  normal_cdf_each(below);
  normal.pearson = pearson_chi2(below, 2, 1);
  const std::vector<CurvePoint> curve = normal_curve(data, fit.maximum.x, result.bins);
  const Bins& bins = result.bins;
  for (std::size_t k = 0; k < bins.counts.size(); ++k)
    normal.expected.push_back(static_cast<double>(data.size()) * (bins.eps_edges[k + 1] - bins.eps_edges[k]) *
                              mean_in_bin(curve, bins.counts.size(), k));
}

HistogramFit fit_histogram(const RestitutionSamples& samples, const std::vector<double>& v_mps, double centre,
                           double width, std::size_t n_min, const LawFit& law) {
  HistogramFit result;
  result.v_mps = centre;
  result.v_lo_mps = centre - 0.5 * width;
  result.v_hi_mps = centre + 0.5 * width;
  const LawData data = window_data(samples, v_mps, result.v_lo_mps, result.v_hi_mps, centre, law);
  result.n = data.size();
  if (result.n > 0) result.bins = bins_of(data.eps);
  if (result.n < std::max<std::size_t>(n_min, 5)) return result;
  const LawModel constant = make_law_model(LawKind::constant, {}, data.v_mps);
  const Eigen::VectorXd start = start_values(*first_look(data, constant), exponentials_of(data));
  const WindowFit fit = fit_window(data, constant, start);
  fit_two_exponentials(result, data, fit);
  if (fit.maximum.converged) compare_with_normal(result, data, Eigen::Vector2d(start[0], 0.5 * (start[1] + start[2])));
  return result;
}

/// The narrowest that gives the median window enough samples.
double chosen_width_mps(const std::vector<double>& v_mps, const std::vector<double>& centres_mps) {
  constexpr std::size_t kEnough = 1000;
  for (const double width : {0.02, 0.05, 0.1}) {
    std::vector<std::size_t> counts;
    for (const double centre : centres_mps)
      counts.push_back(static_cast<std::size_t>(
          std::count_if(v_mps.begin(), v_mps.end(), [&](double v) { return std::abs(v - centre) < 0.5 * width; })));
    std::sort(counts.begin(), counts.end());
    if (!counts.empty() && counts[counts.size() / 2] >= kEnough) return width;
  }
  return 0.2;
}

void check(const HistogramConfig& config) {
  if (!(config.width_mps >= 0.0))
    throw InvalidArgument("width of the histograms' windows " + std::to_string(config.width_mps) +
                          " m/s: must be positive, or 0 to have it chosen");
  for (const double centre : config.centres_mps)
    if (!(centre > 0.0))
      throw InvalidArgument("centre of a histogram's window " + std::to_string(centre) + " m/s: must be positive");
}

}  // namespace

std::optional<bool> slopes_differ(const HistogramFit& h) {
  if (!h.slope_ratio || !h.slope_ratio->identified || !h.slope_ratio->ci95) return std::nullopt;
  return h.slope_ratio->ci95->lo > 1.0 || h.slope_ratio->ci95->hi < 1.0;
}

std::vector<HistogramFit> fit_histograms(const RestitutionSamples& samples, const HistogramConfig& config,
                                         const LawFit& law) {
  check(config);
  const std::vector<double> v_mps = speeds_of(samples);
  const double width = config.width_mps > 0.0 ? config.width_mps : chosen_width_mps(v_mps, config.centres_mps);
  std::vector<HistogramFit> results(config.centres_mps.size());
  parallel_for(results.size(), 0, [&](std::size_t i) {
    results[i] = fit_histogram(samples, v_mps, config.centres_mps[i], width, config.n_min, law);
  });
  return results;
}

const RowColumns<HistogramBin>& columns_of(const HistogramBin*) {
  using B = HistogramBin;
  static const RowColumns<B> all{
      column("v_mps", &B::v_mps,
             "Centre of the window of speeds; ε of its samples is moved there along the fitted law"),
      column("v_lo_mps", &B::v_lo_mps, "Lower end of the window"),
      column("v_hi_mps", &B::v_hi_mps, "Upper end"),
      column("eps_lo", &B::eps_lo, "Lower edge of the bin"),
      column("eps_hi", &B::eps_hi, "Upper edge"),
      column("count", &B::count, "Samples in it"),
      column("density", &B::density,
             "p(ε): `count / (n (eps_hi - eps_lo))`, n all samples of the window, also those outside all bins"),
      column("sigma_density", &B::sigma_density, "Its Poisson error, with √count in place of `count`"),
      column(
          "fitted", &B::fitted,
          "Mean over the bin of the two exponentials that were fitted, blurred by the timing errors; empty where the "
          "window has too few samples")};
  return all;
}

Table histogram_table(const std::vector<HistogramFit>& histograms) {
  std::vector<HistogramBin> rows;
  for (const HistogramFit& h : histograms)
    for (std::size_t k = 0; k < h.bins.counts.size(); ++k) {
      const double lo = h.bins.eps_edges[k], hi = h.bins.eps_edges[k + 1];
      const auto count = static_cast<double>(h.bins.counts[k]), unit = static_cast<double>(h.n) * (hi - lo);
      rows.push_back({h.v_mps, h.v_lo_mps, h.v_hi_mps, lo, hi, static_cast<std::int64_t>(h.bins.counts[k]),
                      count / unit, std::sqrt(count) / unit,
                      h.curve.empty() ? std::nullopt : std::optional(mean_in_bin(h.curve, h.bins.counts.size(), k))});
    }
  return table_of<HistogramBin>(columns_of(rows.data()), rows);
}

DensityPicture density_picture(const RestitutionSamples& samples, std::size_t n_v, std::size_t n_eps) {
  DensityPicture picture;
  std::vector<double> v, eps;
  for (const RestitutionSample& s : samples) {
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) continue;
    v.push_back(s.v_mps);
    eps.push_back(s.eps);
  }
  if (v.size() < 2) return picture;
  const auto most = static_cast<std::size_t>(std::max(4.0, std::sqrt(static_cast<double>(v.size()))));
  n_v = std::min(n_v, most);
  n_eps = std::min(n_eps, most);
  const auto [v_lo, v_hi] = std::minmax_element(v.begin(), v.end());
  std::vector<double> sorted = eps;
  std::sort(sorted.begin(), sorted.end());
  const double lo = sorted[sorted.size() / 1000], hi = sorted[sorted.size() - 1 - sorted.size() / 1000];
  const double margin = std::max(0.1 * (hi - lo), 1e-9);
  picture.v_edges_mps = even_edges(*v_lo, std::max(*v_hi, *v_lo * (1.0 + 1e-9)), n_v);
  picture.eps_edges = even_edges(lo - margin, hi + margin, n_eps);
  picture.counts.assign(n_eps, std::vector<std::size_t>(n_v, 0));
  for (std::size_t k = 0; k < v.size(); ++k) {
    if (eps[k] < picture.eps_edges.front() || eps[k] > picture.eps_edges.back())
      ++picture.n_outside;
    else
      ++picture.counts[bin_of(eps[k], picture.eps_edges)][bin_of(v[k], picture.v_edges_mps)];
  }
  return picture;
}

}  // namespace bouncelab::fit
