// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/memory_result.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/fit/roughness.hpp"
#include "law/maximise.hpp"
#include "law/result_matrix.hpp"
#include "memory/memory_tests.hpp"
#include "memory/posterior.hpp"

namespace bouncelab::fit {
namespace {

/// From so many drops on the likelihood is smooth over a standard error of its maximum. With fewer its corners, where a
/// drop's reservoir is almost empty, are seen: intervals are the posterior's, flat prior but for slip.
constexpr std::size_t kManyDrops = 200;
/// Draws that count: of fewer a standard error is not known to a third.
constexpr double kFewestDraws = 10.0;

/// Inverse of the curvature, by differences of gradients over a third of a standard error along directions that the
/// information matrix holds for independent: along a parameter alone, which others all but make up for, the likelihood
/// is no parabola. Of hundreds of drops the gradient's own bend over that is below a percent. Where the curvature is
/// not that of a maximum, the inverse of the information matrix.
Eigen::MatrixXd inverse_curvature(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
                                  const Eigen::MatrixXd& scores) {
  constexpr double kShare = 0.3;
  const Eigen::MatrixXd white = whitening(scores * scores.transpose() + likelihood.prior_information(theta), 1e-12);
  const Eigen::VectorXd here = scores.rowwise().sum() + likelihood.prior_gradient(theta);
  Eigen::MatrixXd h(theta.size(), theta.size());
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    Eigen::VectorXd there;
    likelihood(theta + kShare * white.col(j), &there);
    h.col(j) = white.transpose() * (here - there) / kShare;
  }
  const Eigen::LLT<Eigen::MatrixXd> root(0.5 * (h + h.transpose()));
  if (root.info() != Eigen::Success) return white * white.transpose();
  return white * root.solve(white.transpose());
}

/// Draws of the parameters that say what is known of them, each with its weight.
Posterior uncertainty(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta, const Eigen::MatrixXd& scores,
                      const MemoryFitConfig& config) {
  const Eigen::MatrixXd by_impact = scores.topRows(likelihood.n_parameters());
  if (likelihood.chains().n_drops < kManyDrops) {
    const Eigen::MatrixXd information = by_impact * by_impact.transpose() + likelihood.prior_information(theta);
    return sample_posterior([&](const Eigen::VectorXd& x) { return likelihood.anew(x) + likelihood.log_prior(x); },
                            theta, 2.0 * information.inverse(), config.n_draws, config.seed);
  }
  // sandwich by drop: holds whatever goes on within a drop
  const Eigen::MatrixXd inverse = inverse_curvature(likelihood, theta, by_impact);
  const Eigen::MatrixXd drops = likelihood.by_drop(by_impact);
  const auto m = static_cast<double>(drops.cols());
  return normal_draws(theta, inverse * (drops * drops.transpose()) * inverse * (m / (m - 1.0)), config.n_draws,
                      config.seed);
}

/// Mean, standard deviation and quantiles of a function of the parameters.
Estimate estimate_of(const Posterior& posterior, const std::function<double(const Eigen::VectorXd&)>& function) {
  Eigen::VectorXd values(posterior.draws.cols());
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = function(posterior.draws.col(k));
  Estimate e;
  e.value = values.dot(posterior.weights);
  e.se = std::sqrt((values.array() - e.value).square().matrix().dot(posterior.weights));
  e.ci68 = interval_of(values, posterior.weights, 0.6826894921370859);
  e.ci95 = interval_of(values, posterior.weights, 0.95);
  return e;
}

/// Covariance of functions of the parameters, by their derivatives at the mean.
Eigen::MatrixXd covariance_of(const Posterior& posterior, const Eigen::MatrixXd& jacobian) {
  const Eigen::Index n = jacobian.cols();
  return jacobian * posterior.covariance.topLeftCorner(n, n) * jacobian.transpose();
}

void describe_law(MemoryFit& fit, const LawModel& model, const Posterior& posterior, std::vector<double> node_speeds,
                  const std::vector<double>& speeds) {
  const Eigen::Index n_law = model.n_parameters();
  const Eigen::VectorXd q = posterior.mean.head(n_law);
  const std::vector<std::string> names = model.names();
  for (std::size_t i = 0; i < names.size(); ++i)
    fit.parameters.push_back({names[i], estimate_of(posterior, [&](const Eigen::VectorXd& theta) {
                                return model.reported(theta.head(n_law))[static_cast<Eigen::Index>(i)];
                              })});
  fit.covariance = to_matrix(covariance_of(posterior, model.reported_jacobian(q)));
  const auto eps_at = [&](double v) {
    return [&, v](const Eigen::VectorXd& theta) { return model.eps(std::span(&v, 1), theta.head(n_law))[0]; };
  };
  if (node_speeds.empty()) node_speeds = spread_speeds(speeds, 3);
  for (const double v : node_speeds) fit.nodes.push_back({v, estimate_of(posterior, eps_at(v))});
  const Eigen::MatrixXd nodes = covariance_of(posterior, model.jacobian(node_speeds, q));
  fit.node_correlation = to_matrix(correlation_of(nodes));
  constexpr int kPoints = 40;
  const auto [lo, hi] = std::minmax_element(speeds.begin(), speeds.end());
  std::vector<double> grid;
  for (int k = 0; k <= kPoints; ++k) grid.push_back(*lo + (*hi - *lo) * k / kPoints);
  const Eigen::VectorXd eps = model.eps(grid, q);
  const Eigen::MatrixXd rows = model.jacobian(grid, q);
  for (Eigen::Index k = 0; k <= kPoints; ++k) {
    const Estimate here = normal_estimate(eps[k], std::sqrt(covariance_of(posterior, rows.row(k))(0, 0)));
    fit.curve.push_back({grid[static_cast<std::size_t>(k)], here.value, here.ci95, here.se});
  }
  fit.law = model.law(q);
}

/// What speaks against the model, in words; empty where nothing does.
std::string objections(const MemoryFit& fit) {
  constexpr double kRejected = 0.01;
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
  if (fit.loglik_independent && fit.loglik < *fit.loglik_independent)
    add("impacts taken as independent are likelier: these fluctuations do not remember as those of a rough ball do");
  if (fit.anderson_darling && fit.anderson_darling->p_value <= kRejected)
    add("the impacts do not scatter as the model says (Anderson-Darling test of the probability transforms)");
  if (fit.mechanism.p_value <= kRejected) add("offset and width of the scatter want different roughness");
  if (fit.by_speed.p_value <= kRejected) add("slow impacts want another roughness than fast ones");
  if (fit.between_drops && fit.between_drops->p_value <= kRejected)
    add("drops differ from each other by more than their impacts say");
  return text;
}

}  // namespace

void describe(MemoryFit& fit, const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
              const Eigen::MatrixXd& scores, const MemoryFitConfig& config, const std::vector<double>& speeds) {
  const Eigen::Index n = likelihood.n_parameters();
  const std::array<MemoryTest*, kTestedParameters> tested{&fit.mechanism, &fit.by_speed};
  std::array<double, kTestedParameters> z{};
  for (std::size_t j = 0; j < tested.size(); ++j) {
    *tested[j] = score_test(likelihood, scores, n + static_cast<Eigen::Index>(j));
    z[j] = tested[j]->z;
  }
  fit.loglik = likelihood.anew(theta);
  const Posterior posterior = uncertainty(likelihood, theta, scores, config);
  if (posterior.effective < kFewestDraws) {
    fit.status = FitStatus::not_converged;
    fit.message = "the errors of the likeliest parameters could not be found: too few draws from the posterior count";
    return;
  }
  describe_law(fit, likelihood.model(), posterior, config.node_speeds_mps, speeds);
  const auto estimate = [&](Eigen::Index i) {
    return estimate_of(posterior, [i](const Eigen::VectorXd& x) { return x[i]; });
  };
  const Estimate q = estimate_of(posterior, [&](const Eigen::VectorXd& x) { return exp(x[likelihood.index_of_q()]); });
  fit.roughness = equivalent_surfaces(q, fit.ball ? fit.ball->inertia_factor : kSolidBallInertia);
  fit.keep = estimate(likelihood.index_of_keep());
  const auto first = [&](const Eigen::VectorXd& x) { return exp(x[likelihood.index_of_first()]); };
  const auto at_rest = [&](const Eigen::VectorXd& x) {
    return likelihood.first_at_rest_m2ps2(exp(x[likelihood.index_of_q()]));
  };
  fit.release_m2ps2 = estimate_of(posterior, [&](const Eigen::VectorXd& x) { return first(x) - at_rest(x); });
  const Estimate excess = estimate_of(posterior, [&](const Eigen::VectorXd& x) { return log(first(x) / at_rest(x)); });
  fit.release.z = excess.value / *excess.se;
  fit.release.p_value = two_sided(fit.release.z);
  fit.leak.z = (fit.keep.value - 1.0) / *fit.keep.se;
  fit.leak.p_value = two_sided(fit.leak.z);
  const std::vector<double> transforms = likelihood.transforms(theta);
  for (const double u : transforms)
    fit.transform_counts[std::min<std::size_t>(19, static_cast<std::size_t>(20.0 * u))] += 1.0;
  if (config.n_goodness > 0) {
    const Eigen::MatrixXd of_fitted = scores.topRows(n);
    const ModelTests tests =
        tests_by_drawing(likelihood, theta, of_fitted * of_fitted.transpose() + likelihood.prior_information(theta), z,
                         config.n_goodness, config.seed);
    fit.anderson_darling = tests.anderson_darling;
    if (fit.n_drops > 1) fit.between_drops = tests.between_drops;
    for (std::size_t j = 0; tests.score_p && j < tested.size(); ++j) tested[j]->p_value = (*tests.score_p)[j];
  }
  fit.message = objections(fit);
  fit.holds = fit.message.empty();
}

}  // namespace bouncelab::fit
