// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibration.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

const std::vector<double> kNodeSpeeds_mps{0.25, 0.6, 1.2};
const std::vector<double> kWindows_mps{0.3, 0.6, 1.0};
constexpr double kWindowWidth_mps = 0.1;
constexpr double kLowestHeight = 0.9;    // of the highest
constexpr std::size_t kSamplesMax = 95;  // of a drop, as in the paper

void check(const CalibrationConfig& c) {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw InvalidArgument(what);
  };
  require(c.n_samples >= 100, "samples per seed " + std::to_string(c.n_samples) + ": at least 100");
  require(c.n_seeds >= 2, "seeds " + std::to_string(c.n_seeds) + ": at least 2");
  require(c.offset_variance > 0.0 && c.offset_variance <= 1e-3, "variance of the offset: must be in (0, 0.001]");
  require(c.inertia_factor > 0.0 && c.inertia_factor <= 1.0, "J/(m R^2): must be in (0, 1]");
  require(c.sigma_eps_at_1mps >= 0.0, "timing error of eps: must not be negative");
  require(c.v_lo_mps > 0.0 && c.v_hi_mps > 1.2 * c.v_lo_mps,
          "speeds: the highest must be 1.2 times the lowest or more");
  const double v = c.v_hi_mps * std::sqrt(kLowestHeight);
  require(v * restitution(c.law, v) > c.v_lo_mps, "law: a drop ends with its first impact, which is no sample");
}

std::vector<int> orders_of(const SeriesLaw& law) {
  std::vector<int> orders;
  for (std::size_t i = 2; i < law.a.size(); ++i)
    if (kViscoelasticC[i] != 0.0) orders.push_back(static_cast<int>(i));
  return orders;
}

struct Sides {
  double b_below, b_above;
};

/// Mean distances from the peak at given speed, averaged over the heights of release.
class Scatter {
 public:
  explicit Scatter(const CalibrationConfig& config) : config_(config) {
    constexpr std::size_t kHeights = 32;
    for (std::size_t i = 0; i < kHeights; ++i) {
      const double height = kLowestHeight + (1.0 - kLowestHeight) * (static_cast<double>(i) + 0.5) / kHeights;
      Path path;
      double sum = 0.0;
      for (double v = config.v_hi_mps * std::sqrt(height);
           path.v_mps.size() < 2 || (path.v_mps.back() > config.v_lo_mps && path.v_mps.size() <= kSamplesMax);) {
        const double e = restitution(config.law, v);
        path.v_mps.push_back(v);
        path.s.push_back(sum);
        sum += square((1.0 + e) * v);
        v *= e;
      }
      paths_.push_back(std::move(path));
    }
  }

  Sides at(double v_mps) const {
    const double unit =
        (1.0 + restitution(config_.law, v_mps)) * config_.offset_variance / (1.0 + config_.inertia_factor);
    double below = 0.0, above = 0.0, n = 0.0;
    for (const Path& path : paths_) {
      if (v_mps >= path.v_mps.front()) continue;
      const double root = std::sqrt(1.0 + path.s_at(v_mps) / square(v_mps));
      below += unit * (root + 1.0);
      above += unit * (root - 1.0);
      n += 1.0;
    }
    return {below / n, above / n};
  }

 private:
  struct Path {
    std::vector<double> v_mps, s;  ///< speeds falling; S before each
    double s_at(double v) const {
      const auto next = std::lower_bound(v_mps.begin() + 1, v_mps.end() - 1, v, std::greater<>());
      const auto k = static_cast<std::size_t>(next - v_mps.begin());
      const double share = (v_mps[k - 1] - v) / (v_mps[k - 1] - v_mps[k]);
      return s[k - 1] + share * (s[k] - s[k - 1]);
    }
  };
  const CalibrationConfig& config_;
  std::vector<Path> paths_;
};

double timing_error(const CalibrationConfig& config, double v_mps) {
  return std::max(config.sigma_eps_at_1mps / v_mps, 1e-12);
}

/// Speeds of the first seed, rising, the two or three beyond the lowest release left out: at most some 4000 of them.
std::vector<double> speeds_of(const CalibrationConfig& config, const RestitutionSamples& samples) {
  constexpr std::size_t kEnough = 4000;
  std::vector<double> v;
  for (const RestitutionSample& s : samples)
    if (s.v_mps < 0.99 * std::sqrt(kLowestHeight) * config.v_hi_mps) v.push_back(s.v_mps);
  std::sort(v.begin(), v.end());
  const std::size_t stride = std::max<std::size_t>(1, v.size() / kEnough);
  std::vector<double> thinned;
  for (std::size_t k = stride / 2; k < v.size(); k += stride) thinned.push_back(v[k]);
  return thinned;
}

/// Cramer-Rao bounds at the truth if samples were independent: of the nodes, then of the constants.
std::vector<double> bounds(const CalibrationConfig& config, const Scatter& scatter, const RestitutionSamples& samples) {
  constexpr Eigen::Index kTerms = 6;
  LawData data;
  data.v_mps = speeds_of(config, samples);
  const auto n = static_cast<Eigen::Index>(data.size());
  Eigen::MatrixXd powers(n, kTerms), log_b(n, 2);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double v = data.v_mps[static_cast<std::size_t>(k)];
    const Sides sides = scatter.at(v);
    for (Eigen::Index i = 0; i < kTerms; ++i) powers(k, i) = power(log(v), static_cast<int>(i));
    log_b.row(k) << log(sides.b_below), log(sides.b_above);
    data.eps.push_back(restitution(config.law, v));
    data.tau.push_back(timing_error(config, v));
    data.drop.push_back(0);
  }
  const LawModel model = make_law_model(LawKind::series, orders_of(config.law), data.v_mps);
  const LawLikelihood likelihood(data, model, {false, kTerms, 1.0});
  const Eigen::Index n_law = model.n_parameters();
  Eigen::VectorXd theta(likelihood.n_parameters());
  for (Eigen::Index j = 0; j < n_law; ++j)
    theta[j] = restitution(config.law, model.node_v_mps[static_cast<std::size_t>(j)]);
  const Eigen::MatrixXd c = least_squares(powers, log_b);
  theta.tail(2 * kTerms) << c.col(0), c.col(1);
  const Eigen::MatrixXd white = whitening(
      likelihood.information(theta) * (static_cast<double>(config.n_samples) / static_cast<double>(n)), 1e-12);
  const Eigen::MatrixXd covariance = gram(white).topLeftCorner(n_law, n_law);
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(kNodeSpeeds_mps.size()) + n_law, n_law);
  rows << model.jacobian(kNodeSpeeds_mps, theta.head(n_law)), model.reported_jacobian(theta.head(n_law));
  std::vector<double> result;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    result.push_back(std::sqrt(congruence(rows.row(i).transpose(), covariance)(0, 0)));
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

/// Cramer-Rao bounds of rising and falling slope in a window if samples were independent, peak and both slopes unknown,
/// the drift inside it known.
std::pair<double, double> slope_bounds(const CalibrationConfig& config, const RestitutionSamples& samples,
                                       const Sides& sides, double v_mps) {
  // as many as make the prior on the sides' ratio negligible
  constexpr std::size_t kCopies = 4000;
  const LawData data{std::vector(kCopies, v_mps),
                     std::vector(kCopies, restitution(config.law, v_mps)),
                     std::vector(kCopies, timing_error(config, v_mps)),
                     std::vector<std::size_t>(kCopies, 0),
                     {},
                     {}};
  const LawModel model = make_law_model(LawKind::constant, {}, data.v_mps);
  const LawLikelihood likelihood(data, model, {false, 1, v_mps});
  Eigen::VectorXd theta(3);
  theta << data.eps[0], log(sides.b_below), log(sides.b_above);
  const auto n = static_cast<double>(std::count_if(samples.begin(), samples.end(), [&](const RestitutionSample& s) {
    return std::abs(s.v_mps - v_mps) < 0.5 * kWindowWidth_mps;
  }));
  const Eigen::MatrixXd white = whitening(likelihood.information(theta) * (n / kCopies), 1e-12);
  const Eigen::VectorXd variances = gram(white).diagonal();
  return {std::sqrt(variances[1]) / sides.b_below, std::sqrt(variances[2]) / sides.b_above};
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
  const Scatter scatter(config);
  const RestitutionSamples samples = calibration_samples(config, 0);  // their speeds
  const std::vector<double> of_law = bounds(config, scatter, samples);
  for (std::size_t j = 0; j < rows.size(); ++j) rows[j].bound_independent = of_law[j];
  for (const double v : windows_of(config)) {
    const Sides sides = scatter.at(v);
    const auto [rising, falling] = slope_bounds(config, samples, sides, v);
    const std::string speed = "(" + std::to_string(v).substr(0, 3) + ")";
    rows.push_back({"rising" + speed, 1.0 / sides.b_below, rising});
    rows.push_back({"falling" + speed, 1.0 / sides.b_above, falling});
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

}  // namespace

RestitutionSamples calibration_samples(const CalibrationConfig& config, std::uint64_t index) {
  Random random(config.seed, RandomStream::test, index);
  const double spread = std::sqrt(config.offset_variance), c = 1.0 / (1.0 + config.inertia_factor);
  RestitutionSamples samples;
  for (std::int64_t drop = 0; samples.size() < config.n_samples; ++drop) {
    double v = config.v_hi_mps * std::sqrt(random.uniform(kLowestHeight, 1.0));
    double u[2] = {0.0, 0.0};  // velocity gained sideways and by spin
    for (std::size_t k = 0; k <= kSamplesMax && v >= config.v_lo_mps && samples.size() < config.n_samples; ++k) {
      const double e = restitution(config.law, v), theta[2] = {spread * random.normal(), spread * random.normal()};
      const double eps =
          e + (1.0 + e) * ((theta[0] * u[0] + theta[1] * u[1]) / v - c * (square(theta[0]) + square(theta[1])));
      const double sigma = config.sigma_eps_at_1mps / v, error = sigma * random.normal();
      if (k > 0) {
        RestitutionSample s;
        s.drop = drop;
        s.impact = static_cast<std::int64_t>(k);
        s.v_mps = v;
        s.eps = eps + error;
        if (sigma > 0.0) s.sigma_eps = sigma;
        samples.push_back(s);
      }
      for (int i = 0; i < 2; ++i) u[i] -= c * (1.0 + e) * v * theta[i];
      v *= eps;
    }
  }
  return samples;
}

CalibrationResult calibrate(const CalibrationConfig& config, const ProgressCallback& progress) {
  validate(config.law);
  check(config);
  LawFitConfig fit_config;
  fit_config.orders = orders_of(config.law);
  fit_config.node_speeds_mps = kNodeSpeeds_mps;
  fit_config.intervals = config.intervals;
  CalibrationResult result;
  result.rows = rows_of(config);
  std::vector<Sums> sums(result.rows.size());
  with_threads(config.n_threads, [&] {
    for (std::size_t i = 0; i < config.n_seeds; ++i) {
      if (progress) progress(static_cast<double>(i), static_cast<double>(config.n_seeds));
      const std::vector<Estimate> found =
          estimates_of(calibration_samples(config, i), fit_config, {windows_of(config), kWindowWidth_mps});
      if (found.size() != sums.size())
        ++result.n_failed;
      else
        for (std::size_t j = 0; j < sums.size(); ++j) sums[j].add(found[j], result.rows[j].truth);
    }
  });
  for (std::size_t j = 0; j < sums.size(); ++j)
    if (sums[j].n > 1.0) sums[j].put(result.rows[j]);
  return result;
}

}  // namespace bouncelab::fit
