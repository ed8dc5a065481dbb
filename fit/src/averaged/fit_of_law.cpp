// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged/fit_of_law.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "law/law_search.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

// Scatter of eps from bounce to bounce, as of two samples, for those who have one or two: few balls do better than
// this on any floor.
constexpr double kScatterOfFew = 0.005;

/// What a law says of the shape of eps(v), as sums of eps at some speeds; each is 0 with a standard deviation
/// beforehand. The viscoelastic law falls by (1 - eps)/5 in a factor e of speed; what yields far above the speed where
/// that begins is in proportion to v^(-1/4) (Johnson, Contact Mechanics, 11.4).
struct Shape {
  std::vector<double> v_mps;
  Eigen::MatrixXd sums;  ///< a row a sum, a column a speed
  Eigen::VectorXd prior_sd;
};
Shape shape_of(const LawModel& model, const LawData& data) {
  constexpr double kSlope = 0.2, kCurvature = 0.25, kStep = 0.5;
  const std::vector<double> ends = spread_speeds(data.v_mps, 2);
  const double eps = median(data.eps), lost = std::max(0.01, 1.0 - eps), ratio = ends[1] / ends[0];
  const double change = model.yields ? eps * (pow(ratio, 0.25) - 1.0) : kSlope * lost * log(ratio);
  Shape shape;
  if (model.kind == LawKind::slope) {
    shape = {ends, Eigen::MatrixXd(1, 2), Eigen::VectorXd(1)};
    shape.sums << -1.0, 1.0;
    shape.prior_sd << change;
  } else if (model.kind == LawKind::series && model.n_parameters() > 2) {
    shape = {{ends[0], std::sqrt(ends[0] * ends[1]), ends[1]}, Eigen::MatrixXd(2, 3), Eigen::VectorXd(2)};
    shape.sums << -1.0, 0.0, 1.0, -0.5, 1.0, -0.5;
    shape.prior_sd << change, kCurvature * change;
  } else if (model.kind == LawKind::step) {
    const double at = model.node_v_mps[2];
    shape = {{ends[0], at * (1.0 - 1e-9), at, ends[1]}, Eigen::MatrixXd(2, 4), Eigen::VectorXd(2)};
    shape.sums << -1.0, 1.0, -1.0, 1.0, 0.0, -1.0, 1.0, 0.0;
    shape.prior_sd << change, kStep * lost;
  }
  return shape;
}

/// What is known of eps at some speeds when the prior of its shape has been taken in. @return minus the logarithm of
/// the likelihood's mean over that prior, relative to its maximum
double take_in(const Shape& shape, Eigen::Index n_nodes, Eigen::VectorXd& eps, Eigen::MatrixXd& covariance) {
  if (shape.v_mps.empty()) return 0.0;
  const Eigen::Index n = eps.size(), n_sums = shape.sums.rows();
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(n_sums, n);
  sums.rightCols(n - n_nodes) = shape.sums;
  const Eigen::MatrixXd with_sums = product(covariance, sums.transpose());
  const Eigen::MatrixXd of_sums = product(sums, with_sums);
  Eigen::MatrixXd total = of_sums;
  total.diagonal() += shape.prior_sd.cwiseAbs2();
  const Eigen::MatrixXd gain = product(with_sums, inverse(total));
  const Eigen::VectorXd found = product(sums, eps);
  const double misfit = found.dot(Eigen::VectorXd(product(inverse(total), found)));
  const auto ln_det = [](const Eigen::MatrixXd& m) {
    const double det = m.rows() == 1 ? m(0, 0) : m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
    return log(std::max(det, 1e-300));
  };
  const double surprise = 0.5 * (ln_det(total) - ln_det(of_sums) + misfit);
  eps -= product(gain, found);
  covariance -= product(gain, Eigen::MatrixXd(with_sums.transpose()));
  return surprise;
}

/// A law with a step where that explains the samples much better than one without, by weighted least squares; the step
/// leaves some samples on either side, or lost impacts would be steps.
std::optional<LawModel> step_of(const LawData& data) {
  constexpr std::size_t kBeside = 4, kMostPlaces = 100;
  const std::size_t n = data.size();
  if (n < 3 * kBeside) return std::nullopt;
  const auto rows = static_cast<Eigen::Index>(n);
  const Eigen::Map<const Eigen::VectorXd> eps(data.eps.data(), rows);
  Eigen::VectorXd root_weights = Eigen::VectorXd::Ones(rows);
  const auto residuals_of = [&](const LawModel& model) -> Eigen::VectorXd {
    const Eigen::MatrixXd j = root_weights.asDiagonal() * model.jacobian(data.v_mps, {});
    const Eigen::VectorXd y = root_weights.cwiseProduct(eps);
    return y - product(j, least_squares(j, y));
  };
  const LawModel without = make_law_model(LawKind::slope, {}, data.v_mps);
  const Eigen::VectorXd first = residuals_of(without).cwiseAbs();
  constexpr double kOfNormal = 1.4826;  // standard deviation over the median distance
  const double scatter = kOfNormal * median({first.data(), first.data() + rows});
  for (std::size_t k = 0; k < n; ++k) root_weights[static_cast<Eigen::Index>(k)] = 1.0 / hypot(data.tau[k], scatter);
  const auto length = static_cast<double>(n);
  double least = residuals_of(without).squaredNorm();
  const double enough = least * exp(-2.0 * (log(length) + 2.0) / length);
  std::optional<LawModel> best;
  const std::size_t stride = 1 + n / kMostPlaces;
  for (std::size_t k = kBeside; k + kBeside <= n; k += stride) {
    LawModel model = make_step_model(data.v_mps, std::sqrt(data.v_mps[k - 1] * data.v_mps[k]));
    const double squares = residuals_of(model).squaredNorm();
    if (squares < least) least = squares, best = std::move(model);
  }
  return least < enough ? best : std::nullopt;
}

/// Of a single eps about the law, root mean square. Scatter goes as v^-p, p from 0 to 1 (docs/physics.md: asperities
/// make 1): the mean over p = 0, 1/2, 1, by how likely each makes the residuals.
double scatter_at_greatest_speed(const LawLikelihood& likelihood, const Eigen::VectorXd& theta) {
  const LawData& data = likelihood.data();
  std::array<double, 3> squares{};  // of the residuals, each times (v/v_greatest)^(2 p)
  double ln_ratios = 0.0;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const double ratio = data.v_mps[k] / data.v_mps.back();
    double part = square(data.eps[k] - likelihood.eps_of(theta, k));
    for (double& sum : squares) sum += part, part *= ratio;
    ln_ratios += log(ratio);
  }
  const auto n = static_cast<double>(data.size());
  std::array<double, 3> ln_likelihood{};
  for (std::size_t i = 0; i < squares.size(); ++i)
    ln_likelihood[i] = 0.5 * static_cast<double>(i) * ln_ratios - 0.5 * n * log(std::max(1e-300, squares[i]));
  const double most = *std::max_element(ln_likelihood.begin(), ln_likelihood.end());
  double weights = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double weight = exp(ln_likelihood[i] - most);
    weights += weight, sum += weight * squares[i];
  }
  return std::sqrt(sum / weights / std::max(1.0, n - static_cast<double>(likelihood.model().n_parameters())));
}

}  // namespace

Fitted fit_of(const LawData& data, const LawModel& model, const LawFitConfig& config,
              const std::vector<double>& wanted_mps, std::size_t middle) {
  Fitted fitted;
  std::optional<Candidate> candidate = best_candidate(data, model, config);
  constexpr double kLittle = 0.05;  // of log-likelihood: a search that stopped so near its end knows enough
  if (!candidate || (!candidate->maximum.converged && !(candidate->maximum.gain_left < kLittle))) return fitted;
  candidate->data.basis = make_law_basis(model, candidate->data.v_mps);
  const LawLikelihood likelihood(candidate->data, model, candidate->family);
  LawFit fit;
  fit.n = data.size();
  const Shape shape = shape_of(model, data);
  std::vector<double> speeds_mps = wanted_mps;
  speeds_mps.insert(speeds_mps.end(), shape.v_mps.begin(), shape.v_mps.end());
  describe_nodes(fit, likelihood, candidate->maximum, speeds_mps);
  const auto n_speeds = static_cast<Eigen::Index>(speeds_mps.size()),
             n_wanted = static_cast<Eigen::Index>(wanted_mps.size());
  Eigen::VectorXd eps(n_speeds);
  Eigen::MatrixXd covariance(n_speeds, n_speeds);
  for (Eigen::Index i = 0; i < n_speeds; ++i) {
    const auto a = static_cast<std::size_t>(i);
    eps[i] = fit.nodes[a].eps.value;
    for (Eigen::Index j = 0; j < n_speeds; ++j) {
      const auto b = static_cast<std::size_t>(j);
      covariance(i, j) = fit.nodes[a].eps.se.value_or(0.0) * fit.nodes[b].eps.se.value_or(0.0) *
                         (a == b ? 1.0 : fit.node_correlation[a][b]);
    }
  }
  const auto n = static_cast<double>(data.size());
  const auto n_scatter = static_cast<double>(fit.n_parameters) - static_cast<double>(model.n_parameters());
  fitted.surprise = 0.5 * n_scatter * log(n) - candidate->maximum.loglik + take_in(shape, n_wanted, eps, covariance);
  const auto m = static_cast<Eigen::Index>(middle);
  for (Eigen::Index j = 0; j < n_wanted; ++j) {
    fitted.eps.push_back(eps[j]);
    fitted.se.push_back(std::sqrt(std::max(0.0, covariance(j, j))));
    fitted.change_se.push_back(
        model.n_parameters() == 1 && model.is_linear()
            ? 0.0
            : std::sqrt(std::max(0.0, covariance(j, j) + covariance(m, m) - 2.0 * covariance(j, m))));
  }
  fitted.scatter = scatter_at_greatest_speed(likelihood, candidate->maximum.x);
  if (fit.drops.errors == ErrorBasis::independent_samples) {
    fitted.nu = std::max(1.0, n - static_cast<double>(model.n_parameters()) - 1.0);
  } else if (const Estimate& e = fit.nodes[middle].eps; e.se && *e.se > 0.0 && e.ci95) {
    fitted.stretch = (e.ci95->hi - e.ci95->lo) / (2.0 * 1.959963984540054 * *e.se);
  }
  return fitted;
}

Fitted fit_of_few(const LawData& data, std::size_t n_speeds) {
  const auto n = static_cast<double>(data.size());
  double weights = 0.0, sum = 0.0;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const double w = 1.0 / (square(data.tau[k]) + square(kScatterOfFew));
    weights += w, sum += w * data.eps[k];
  }
  const double mean = sum / weights;
  double own = 0.0;
  for (const double eps : data.eps) own += square(eps - mean);
  const double timing =
      std::accumulate(data.tau.begin(), data.tau.end(), 0.0, [](double a, double tau) { return a + tau * tau; }) / n;
  const double nu = 2.0 + (n - 1.0);
  const double scatter2 = (2.0 * square(kScatterOfFew) + std::max(0.0, own - (n - 1.0) * timing)) / nu;
  Fitted fitted;
  fitted.surprise = 0.0;
  fitted.eps.assign(n_speeds, mean);
  fitted.se.assign(n_speeds, std::sqrt((scatter2 + timing) / n));
  fitted.change_se.assign(n_speeds, 0.0);
  fitted.scatter = std::sqrt(scatter2);
  fitted.nu = nu;
  return fitted;
}

std::vector<LawModel> models_of(const LawData& data, const LawFitConfig& config) {
  const std::size_t n = data.size();
  const double lo = data.v_mps[n / 20], hi = data.v_mps[n - 1 - n / 20];
  std::vector<LawModel> models;
  const auto add = [&](LawKind kind, const std::vector<int>& orders, bool yields = false) {
    models.push_back(make_law_model(kind, orders, data.v_mps));
    models.back().yields = yields;
  };
  const LawFitConfig usual;
  if (config.kind != usual.kind || config.orders != usual.orders) {
    add(config.kind, config.orders);
    return models;
  }
  add(LawKind::constant, {});
  if (n < 4 || hi < kOneSpeed * lo) return models;
  add(LawKind::viscoelastic, {});
  for (const bool yields : {false, true}) {
    add(LawKind::slope, {}, yields);
    if (n > 5) add(LawKind::series, config.orders, yields);
  }
  if (std::optional<LawModel> step = step_of(data)) models.push_back(*std::move(step));
  return models;
}

}  // namespace bouncelab::fit
