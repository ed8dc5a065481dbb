// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "law/law_likelihood.hpp"
#include "law/maximise.hpp"

namespace bouncelab::fit {
namespace {

const std::vector<double> kNodeSpeeds_mps{0.25, 0.6, 1.2};
const std::vector<double> kWindows_mps{0.3, 0.6, 1.0};
constexpr double kWindowWidth_mps = 0.1;

void check(const CalibrationConfig& c) {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw InvalidArgument(what);
  };
  require(c.n_samples >= 100, "samples per seed " + std::to_string(c.n_samples) + ": at least 100");
  require(c.n_seeds >= 2, "seeds " + std::to_string(c.n_seeds) + ": at least 2");
  require(c.below_at_1mps > 0.0 && c.above_at_1mps > 0.0, "mean distances from the peak: must be positive");
  require(c.sigma_eps_at_1mps >= 0.0, "timing error of eps: must not be negative");
  require(c.v_lo_mps > 0.0 && c.v_hi_mps > 1.2 * c.v_lo_mps,
          "speeds: the highest must be 1.2 times the lowest or more");
}

std::vector<int> orders_of(const SeriesLaw& law) {
  std::vector<int> orders;
  for (std::size_t i = 2; i < law.a.size(); ++i)
    if (kViscoelasticC[i] != 0.0) orders.push_back(static_cast<int>(i));
  return orders;
}

/// Cramer-Rao bounds at the truth: of the nodes, then of the constants.
std::vector<double> bounds(const CalibrationConfig& config) {
  LawData data;
  constexpr std::size_t kGrid = 4000;
  for (std::size_t k = 0; k < kGrid; ++k) {
    const double v = config.v_lo_mps * pow(config.v_hi_mps / config.v_lo_mps, (static_cast<double>(k) + 0.5) / kGrid);
    data.v_mps.push_back(v);
    data.eps.push_back(restitution(config.law, v));
    data.tau.push_back(std::max(config.sigma_eps_at_1mps / v, 1e-12));
    data.drop.push_back(0);
  }
  const LawModel model = make_law_model(LawKind::series, orders_of(config.law), data.v_mps);
  const LawLikelihood likelihood(data, model, {ScatterKind::asymmetric_laplace, 3, 1.0});
  const Eigen::Index n_law = model.n_parameters();
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(likelihood.n_parameters());
  for (Eigen::Index j = 0; j < n_law; ++j)
    theta[j] = restitution(config.law, model.node_v_mps[static_cast<std::size_t>(j)]);
  theta.segment(n_law, 2) << log(config.below_at_1mps), -1.0;
  theta.segment(n_law + 3, 2) << log(config.above_at_1mps), -1.0;
  const Eigen::MatrixXd white =
      whitening(likelihood.information(theta) * (static_cast<double>(config.n_samples) / kGrid), 1e-12);
  const Eigen::MatrixXd covariance = (white * white.transpose()).topLeftCorner(n_law, n_law);
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(kNodeSpeeds_mps.size()) + n_law, n_law);
  rows << model.jacobian(kNodeSpeeds_mps, theta.head(n_law)), model.reported_jacobian(theta.head(n_law));
  std::vector<double> result;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    result.push_back(std::sqrt(rows.row(i) * covariance * rows.row(i).transpose()));
  return result;
}

/// Windows of p(eps) that lie among the speeds.
std::vector<double> windows_of(const CalibrationConfig& config) {
  std::vector<double> windows;
  for (const double v : kWindows_mps)
    if (v - 0.5 * kWindowWidth_mps >= config.v_lo_mps && v + 0.5 * kWindowWidth_mps <= config.v_hi_mps)
      windows.push_back(v);
  return windows;
}

/// Cramer-Rao bounds of rising and falling slope in a window, peak and both slopes unknown, the drift inside it known.
std::pair<double, double> slope_bounds(const CalibrationConfig& config, double v_mps) {
  // as many as make the prior on the sides' ratio negligible
  constexpr std::size_t kCopies = 4000;
  const double tau = std::max(config.sigma_eps_at_1mps / v_mps, 1e-12);
  const LawData data{std::vector(kCopies, v_mps), std::vector(kCopies, restitution(config.law, v_mps)),
                     std::vector(kCopies, tau), std::vector<std::size_t>(kCopies, 0)};
  const LawModel model = make_law_model(LawKind::constant, {}, data.v_mps);
  const LawLikelihood likelihood(data, model, {ScatterKind::asymmetric_laplace, 1, v_mps});
  Eigen::VectorXd theta(3);
  theta << data.eps[0], log(config.below_at_1mps / v_mps), log(config.above_at_1mps / v_mps);
  const double n = static_cast<double>(config.n_samples) *
                   log((v_mps + 0.5 * kWindowWidth_mps) / (v_mps - 0.5 * kWindowWidth_mps)) /
                   log(config.v_hi_mps / config.v_lo_mps);
  const Eigen::MatrixXd white = whitening(likelihood.information(theta) * (n / kCopies), 1e-12);
  const Eigen::VectorXd variances = (white * white.transpose()).diagonal();
  return {std::sqrt(variances[1]) * v_mps / config.below_at_1mps,
          std::sqrt(variances[2]) * v_mps / config.above_at_1mps};
}

struct Sums {
  double n = 0.0, x = 0.0, xx = 0.0, se = 0.0, pull = 0.0, pull2 = 0.0, in68 = 0.0, in95 = 0.0;
  void add(const Estimate& e, double truth) {
    const double pull_here = (e.value - truth) / *e.se;
    n += 1.0;
    x += e.value - truth;
    xx += (e.value - truth) * (e.value - truth);
    se += *e.se;
    pull += pull_here;
    pull2 += pull_here * pull_here;
    in68 += e.ci68->lo <= truth && truth <= e.ci68->hi ? 1.0 : 0.0;
    in95 += e.ci95->lo <= truth && truth <= e.ci95->hi ? 1.0 : 0.0;
  }
  void put(CalibrationRow& row) const {
    row.spread = std::sqrt((xx - x * x / n) / (n - 1.0));
    row.mean_se = se / n;
    row.pull_mean = pull / n;
    row.pull_sd = std::sqrt((pull2 - pull * pull / n) / (n - 1.0));
    row.coverage68 = in68 / n;
    row.coverage95 = in95 / n;
  }
};

std::vector<CalibrationRow> rows_of(const CalibrationConfig& config) {
  std::vector<CalibrationRow> rows;
  for (const double v : kNodeSpeeds_mps) {
    std::string speed = std::to_string(v);
    rows.push_back({"eps(" + speed.substr(0, 4) + ")", restitution(config.law, v)});
  }
  for (const int order : orders_of(config.law))
    rows.push_back({"A" + std::to_string(order), config.law.a[static_cast<std::size_t>(order)]});
  const std::vector<double> cramer_rao = bounds(config);
  for (std::size_t j = 0; j < rows.size(); ++j) rows[j].cramer_rao = cramer_rao[j];
  for (const double v : windows_of(config)) {
    const auto [rising, falling] = slope_bounds(config, v);
    const std::string speed = "(" + std::to_string(v).substr(0, 3) + ")";
    rows.push_back({"rising" + speed, v / config.below_at_1mps, rising});
    rows.push_back({"falling" + speed, v / config.above_at_1mps, falling});
  }
  return rows;
}

/// What a seed's samples say, in the order of the rows; empty where the search did not converge.
std::vector<Estimate> estimates_of(const RestitutionSamples& samples, const LawFitConfig& law,
                                   const HistogramConfig& windows) {
  const LawFit fit = fit_law(samples, law);
  if (fit.status == FitStatus::not_converged || fit.nodes.empty()) return {};
  std::vector<Estimate> estimates;
  for (const NodeEstimate& node : fit.nodes) estimates.push_back(node.eps);
  for (const NamedEstimate& parameter : fit.parameters) estimates.push_back(parameter.estimate);
  for (const HistogramFit& window : fit_histograms(samples, windows, fit)) {
    if (!window.slope_rising || window.status == FitStatus::not_converged) return {};
    estimates.push_back(*window.slope_rising);
    estimates.push_back(*window.slope_falling);
  }
  return estimates;
}

CalibrationResult calibrate_on_these_threads(const CalibrationConfig& config, const ProgressCallback& progress) {
  CalibrationResult result;
  result.rows = rows_of(config);
  std::vector<Sums> sums(result.rows.size());
  LawFitConfig fit_config;
  fit_config.orders = orders_of(config.law);
  fit_config.node_speeds_mps = kNodeSpeeds_mps;
  fit_config.intervals = config.intervals;
  const HistogramConfig windows{windows_of(config), kWindowWidth_mps};
  for (std::size_t i = 0; i < config.n_seeds; ++i) {
    if (progress) progress(static_cast<double>(i), static_cast<double>(config.n_seeds));
    const std::vector<Estimate> found = estimates_of(calibration_samples(config, i), fit_config, windows);
    if (found.size() != sums.size()) {
      ++result.n_failed;
      continue;
    }
    for (std::size_t j = 0; j < sums.size(); ++j) sums[j].add(found[j], result.rows[j].truth);
  }
  for (std::size_t j = 0; j < sums.size(); ++j)
    if (sums[j].n > 1.0) sums[j].put(result.rows[j]);
  return result;
}

}  // namespace

RestitutionSamples calibration_samples(const CalibrationConfig& config, std::uint64_t index) {
  constexpr std::size_t kPerDrop = 95;
  Random random(config.seed, RandomStream::test, index);
  RestitutionSamples samples(config.n_samples);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    RestitutionSample& s = samples[k];
    s.drop = static_cast<std::int64_t>(k / kPerDrop);
    s.impact = static_cast<std::int64_t>(k % kPerDrop);
    s.v_mps = config.v_lo_mps * pow(config.v_hi_mps / config.v_lo_mps, random.uniform());
    const double below = config.below_at_1mps / s.v_mps, above = config.above_at_1mps / s.v_mps;
    const double scatter =
        random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
    const double sigma = config.sigma_eps_at_1mps / s.v_mps;
    s.eps = restitution(config.law, s.v_mps) + scatter + sigma * random.normal();
    if (sigma > 0.0) s.sigma_eps = sigma;
  }
  return samples;
}

CalibrationResult calibrate(const CalibrationConfig& config, const ProgressCallback& progress) {
  check(config);
  validate(config.law);
  CalibrationResult result;
  with_threads(config.n_threads, [&] { result = calibrate_on_these_threads(config, progress); });
  return result;
}

}  // namespace bouncelab::fit
