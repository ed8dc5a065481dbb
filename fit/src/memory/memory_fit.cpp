// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/fit/roughness.hpp"
#include "law/maximise.hpp"
#include "law/result_matrix.hpp"
#include "memory/memory_likelihood.hpp"
#include "memory/memory_tests.hpp"
#include "memory/posterior.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestImpacts = 60, kShortestLongest = 10;
/// From so many drops on the likelihood is smooth over a standard error of its maximum. With fewer its corners, where a
/// drop's reservoir is almost empty, are seen: intervals are the posterior's under a flat prior.
constexpr std::size_t kManyDrops = 200;
constexpr std::size_t kFewImpacts = 8000;
constexpr double kReleaseSeen = 0.05;  // of the test of a release at rest: below, what it left is fitted

std::vector<double> speeds_of(const RestitutionSamples& samples) {
  std::vector<double> v;
  for (const RestitutionSample& s : samples) v.push_back(s.v_mps);
  return v;
}

/// log q by the mean distances from the peak: their product is ((1 + e) q)^2 S / v^2.
double first_log_q(const Chains& chains, const LawFit& independent) {
  double sum = 0.0;
  for (const Chain& chain : chains.chains) {
    double s = chain.s_before;
    for (const ChainImpact& m : chain.impacts) {
      const double b2 = independent.scatter->below(m.v_mps) * independent.scatter->above(m.v_mps);
      const double one_e = 1.0 + restitution(*independent.law, m.v_mps);
      sum += 0.5 * log(b2 * square(m.v_mps / one_e) / s);
      s += square(one_e * m.v_mps);
    }
  }
  return sum / static_cast<double>(chains.n_impacts);
}

Eigen::VectorXd first_theta(const Chains& chains, const LawModel& model, const LawFit& independent,
                            Eigen::Index n_parameters) {
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(n_parameters);
  const Eigen::Index n_law = model.n_parameters();
  if (model.kind == LawKind::viscoelastic) {
    const double v = chains.chains.front().impacts.front().v_mps;
    theta[0] = log_gamma_through(v, restitution(*independent.law, v));
  } else if (model.kind == LawKind::constant) {
    theta[0] = restitution(*independent.law, chains.chains.front().impacts.front().v_mps);
  } else {
    for (Eigen::Index j = 0; j < n_law; ++j)
      theta[j] = restitution(*independent.law, model.node_v_mps[static_cast<std::size_t>(j)]);
  }
  theta[n_law] = first_log_q(chains, independent);
  theta[n_law + 1] = 1.0;
  return theta;
}

/// Information by the scores of all impacts.
Eigen::MatrixXd information_of(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta) {
  const Eigen::MatrixXd scores = likelihood.scores_by_impact(theta).topRows(likelihood.n_parameters());
  return scores * scores.transpose();
}

/// The plan is good near where it was made, so it is made anew where each search ended.
Maximum search(MemoryLikelihood& likelihood, Eigen::VectorXd theta) {
  constexpr int kMostRounds = 6;
  Maximum maximum;
  for (int round = 0; round < kMostRounds; ++round) {
    likelihood.plan_at(theta);
    const Eigen::MatrixXd information = information_of(likelihood, theta);
    maximum = maximise([&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); }, theta,
                       information, 0.02);
    if (!std::isfinite(maximum.loglik)) return maximum;
    const Eigen::VectorXd step = maximum.x - theta;
    theta = maximum.x;
    if (step.dot(information * step) < 0.1 && round > 0) break;
  }
  likelihood.plan_at(theta);
  return maximum;
}

/// Curvature by differences of gradients over a standard error each way.
Eigen::MatrixXd curvature(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
                          const Eigen::MatrixXd& information) {
  const Eigen::VectorXd step = information.inverse().diagonal().cwiseSqrt();
  Eigen::MatrixXd h(theta.size(), theta.size());
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    Eigen::VectorXd up, down;
    likelihood(theta + step[j] * Eigen::VectorXd::Unit(theta.size(), j), &up);
    likelihood(theta - step[j] * Eigen::VectorXd::Unit(theta.size(), j), &down);
    h.col(j) = (down - up) / (2.0 * step[j]);
  }
  return 0.5 * (h + h.transpose());
}

/// Draws of the parameters that say what is known of them, each with its weight.
Posterior uncertainty(const MemoryLikelihood& likelihood, const Maximum& maximum, const Eigen::MatrixXd& scores,
                      const MemoryFitConfig& config) {
  const Eigen::MatrixXd by_impact = scores.topRows(likelihood.n_parameters());
  const Eigen::MatrixXd information = by_impact * by_impact.transpose();
  if (likelihood.chains().n_drops < kManyDrops)
    return sample_posterior([&](const Eigen::VectorXd& theta) { return likelihood.anew(theta); }, maximum.x,
                            2.0 * information.inverse(), config.n_draws, config.seed);
  // sandwich by drop: holds whatever goes on within a drop
  const Eigen::MatrixXd inverse = curvature(likelihood, maximum.x, information).inverse();
  const Eigen::MatrixXd drops = likelihood.by_drop(by_impact);
  const auto m = static_cast<double>(drops.cols());
  return normal_draws(maximum.x, inverse * (drops * drops.transpose()) * inverse * (m / (m - 1.0)), config.n_draws,
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

/// log-likelihood of the same impacts, taken as independent, of their speeds after the impact.
double loglik_independent(const Chains& chains, const LawFit& independent) {
  // of eps, by v for a density of the speed after it
  double sum = independent.loglik.value_or(0.0);
  for (const Chain& chain : chains.chains)
    for (const ChainImpact& m : chain.impacts) sum -= log(m.v_mps);
  return sum;
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
  if (fit.mechanism.p_value < kRejected) add("offset and width of the scatter want different roughness");
  return text;
}

bool found(const Maximum& maximum) { return std::isfinite(maximum.loglik) && maximum.gain_left < 0.5; }

/// Of balls at rest when released.
double mean_first_reservoir(const Chains& chains, double q) {
  double sum = 0.0;
  for (const Chain& chain : chains.chains) sum += 2.0 * q * chain.s_before;
  return sum / static_cast<double>(chains.chains.size());
}

/// What the maximum says, how well it is known, and whether the model may be believed.
void describe(MemoryFit& fit, const MemoryLikelihood& likelihood, const Maximum& maximum, const MemoryFitConfig& config,
              const std::vector<double>& speeds) {
  const Eigen::MatrixXd scores = likelihood.scores_by_impact(maximum.x);
  const Eigen::Index n = likelihood.n_parameters();
  fit.mechanism = score_test(likelihood, scores, scores.rows() - 1);
  fit.loglik = likelihood.anew(maximum.x);
  const Posterior posterior = uncertainty(likelihood, maximum, scores, config);
  describe_law(fit, likelihood.model(), posterior, config.node_speeds_mps, speeds);
  const auto estimate = [&](Eigen::Index i) {
    return estimate_of(posterior, [i](const Eigen::VectorXd& theta) { return theta[i]; });
  };
  const Estimate q =
      estimate_of(posterior, [&](const Eigen::VectorXd& theta) { return exp(theta[likelihood.index_of_q()]); });
  fit.roughness = equivalent_surfaces(q, kSolidBallInertia);
  fit.keep = estimate(likelihood.index_of_keep());
  if (n > likelihood.index_of_release()) fit.release_m2ps2 = estimate(likelihood.index_of_release());
  fit.leak.z = (fit.keep.value - 1.0) / *fit.keep.se;
  fit.leak.p_value = two_sided(fit.leak.z);
  const std::vector<double> transforms = likelihood.transforms(maximum.x);
  for (const double u : transforms)
    fit.transform_counts[std::min<std::size_t>(19, static_cast<std::size_t>(20.0 * u))] += 1.0;
  if (config.n_goodness > 0) {
    const Eigen::MatrixXd of_fitted = scores.topRows(n);
    fit.anderson_darling = anderson_darling_with_memory(likelihood, maximum.x, of_fitted * of_fitted.transpose(),
                                                        config.n_goodness, config.seed);
  }
  fit.message = objections(fit);
  fit.holds = fit.message.empty();
}

}  // namespace

MemoryFit fit_memory(const RestitutionSamples& samples, const LawFit& independent, const MemoryFitConfig& config) {
  MemoryFit fit;
  if (config.kind == LawKind::series && config.orders.size() > kMostMemoryLawParameters)
    throw InvalidArgument("orders of the series: with memory at most " + std::to_string(kMostMemoryLawParameters));
  if (!independent.law || !independent.scatter) {
    fit.message = "no law to start from";
    return fit;
  }
  const Chains chains = chains_of(samples, independent.outliers, *independent.law);
  fit.n = chains.n_impacts;
  fit.n_drops = chains.n_drops;
  fit.n_chains = chains.chains.size();
  std::size_t longest = 0;
  for (const Chain& chain : chains.chains) longest = std::max(longest, chain.impacts.size());
  if (fit.n < kFewestImpacts || longest < kShortestLongest) {
    fit.message = "memory needs " + std::to_string(kFewestImpacts) + " impacts, and drops of " +
                  std::to_string(kShortestLongest) + " successive ones";
    return fit;
  }
  const std::vector<double> speeds = speeds_of(samples);
  const LawModel model = make_law_model(config.kind, config.orders, speeds);
  MemoryLikelihood likelihood(chains, model, false);
  Eigen::VectorXd start = first_theta(chains, model, independent, likelihood.n_parameters());
  if (chains.n_impacts > 2 * kFewImpacts) {
    // near the maximum by a part of the chains: of all, each step takes long
    const Chains few = thinned_chains(chains, kFewImpacts);
    MemoryLikelihood part(few, model, false);
    const Maximum there = search(part, start);
    if (std::isfinite(there.loglik)) start = there.x;
  }
  const Maximum maximum = search(likelihood, start);
  if (!found(maximum)) {
    fit.status = FitStatus::not_converged;
    fit.message =
        "the search for the likeliest parameters did not converge: these fluctuations are not those of a "
        "rough ball's memory";
    return fit;
  }
  fit.loglik_independent = loglik_independent(chains, independent);
  fit.release = score_test(likelihood, likelihood.scores_by_impact(maximum.x), likelihood.n_parameters());
  fit.status = FitStatus::ok;
  // balls that were released with spin or sideways motion
  if (fit.release.z > 0.0 && fit.release.p_value < kReleaseSeen) {
    MemoryLikelihood moving(chains, model, true);
    Eigen::VectorXd with_release(maximum.x.size() + 1);
    with_release << maximum.x, mean_first_reservoir(chains, exp(maximum.x[likelihood.index_of_q()]));
    const Maximum there = search(moving, with_release);
    if (found(there)) {
      describe(fit, moving, there, config, speeds);
      return fit;
    }
  }
  describe(fit, likelihood, maximum, config, speeds);
  return fit;
}

}  // namespace bouncelab::fit
