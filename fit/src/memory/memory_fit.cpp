// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "law/law_search.hpp"
#include "memory/memory_likelihood.hpp"
#include "memory/posterior.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestImpacts = 60, kShortestLongest = 10;
constexpr std::size_t kFewImpacts = 8000;

/// log q by the mean distances from the peak: their product is ((1 + e) q)^2 S / v^2, S greater by `release` where the
/// release left 2 q times as much.
double first_log_q(const Chains& chains, const LawFit& independent, double release) {
  double sum = 0.0;
  for (const Chain& chain : chains.chains) {
    double s = chain.s_before + release;
    for (const ChainImpact& m : chain.impacts) {
      const double b2 = independent.scatter->below(m.v_mps) * independent.scatter->above(m.v_mps);
      const double one_e = 1.0 + restitution(*independent.law, m.v_mps);
      sum += 0.5 * log(b2 * square(m.v_mps / one_e) / s);
      s += square(one_e * m.v_mps);
    }
  }
  return sum / static_cast<double>(chains.n_impacts);
}

/// @param ratio  of the mean reservoir before the first impacts to that of balls at rest when released, >= 1
Eigen::VectorXd start_with(const Chains& chains, const LawModel& model, const LawFit& independent, double ratio,
                           Eigen::Index n_parameters) {
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(n_parameters);
  const Eigen::Index n_law = model.n_parameters();
  theta.head(n_law) = model.values_of(*independent.law);
  const double s = chains.least_s_before, log_q = first_log_q(chains, independent, (ratio - 1.0) * s);
  theta[n_law] = log_q;
  theta[n_law + 1] = 1.0;
  theta[n_law + 2] = log_q + log(2.0 * s * ratio);
  return theta;
}

/// The likeliest of several starts: the same scatter may be that of a rough ball at rest or of a smoother one that
/// spins, and between them the likelihood can have two maxima.
Eigen::VectorXd first_theta(const MemoryLikelihood& likelihood, const LawFit& independent) {
  Eigen::VectorXd best;
  double highest = -HUGE_VAL;
  for (const double ratio : {1.0, 10.0, 100.0, 1000.0}) {
    const Eigen::VectorXd theta =
        start_with(likelihood.chains(), likelihood.model(), independent, ratio, likelihood.n_parameters());
    const double value = likelihood.anew(theta) + likelihood.log_prior(theta);
    if (best.size() > 0 && !(value > highest)) continue;
    highest = value;
    best = theta;
  }
  return best;
}

/// Where a search ended.
struct Found {
  Maximum maximum;
  Eigen::MatrixXd scores;  ///< scores_by_impact() there
};

/// The plan is good near where it was made, so it is made anew where each search ended.
Found search(MemoryLikelihood& likelihood, Eigen::VectorXd theta) {
  constexpr int kMostRounds = 6;
  // of a standard error: of 220,000 impacts a sum of logarithms is not known well enough for much less
  constexpr double kTolerance = 0.05;
  Found found;
  likelihood.plan_at(theta);
  found.scores = likelihood.scores_by_impact(theta);
  for (int round = 0; round < kMostRounds; ++round) {
    const Eigen::MatrixXd fitted = found.scores.topRows(likelihood.n_parameters());
    const Eigen::MatrixXd information = gram(fitted) + likelihood.prior_information(theta);
    found.maximum = maximise([&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); }, theta,
                             information, kTolerance);
    if (!std::isfinite(found.maximum.loglik)) return found;
    const Eigen::VectorXd step = found.maximum.x - theta;
    theta = found.maximum.x;
    likelihood.plan_at(theta);
    found.scores = likelihood.scores_by_impact(theta);
    if (step.dot(information * step) < 0.1) break;
  }
  return found;
}

/// log-likelihood of the same impacts, taken as independent, of their speeds after the impact.
double loglik_independent(const Chains& chains, const LawFit& independent) {
  // of eps, by v for a density of the speed after it
  double sum = independent.loglik.value_or(0.0);
  for (const Chain& chain : chains.chains)
    for (const ChainImpact& m : chain.impacts) sum -= log(m.v_mps);
  return sum;
}

bool succeeded(const Found& found) { return std::isfinite(found.maximum.loglik) && found.maximum.gain_left < 0.5; }

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
  const Eigen::MatrixXd white = whitening(gram(scores) + likelihood.prior_information(theta), 1e-12);
  const Eigen::VectorXd here = scores.rowwise().sum() + likelihood.prior_gradient(theta);
  Eigen::MatrixXd h(theta.size(), theta.size());
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    Eigen::VectorXd there;
    likelihood(theta + kShare * white.col(j), &there);
    h.col(j) = transposed_product(white, here - there) / kShare;
  }
  const std::optional<Cholesky> root = cholesky(0.5 * (h + h.transpose()));
  return root ? product(white, root->solve(white.transpose())) : gram(white);
}

/// Draws of the parameters that say what is known of them, each with its weight.
Posterior uncertainty(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta, const Eigen::MatrixXd& scores,
                      const MemoryFitConfig& config) {
  const Eigen::MatrixXd by_impact = scores.topRows(likelihood.n_parameters());
  if (likelihood.chains().n_drops < kManyDrops) {
    const Eigen::MatrixXd information = gram(by_impact) + likelihood.prior_information(theta);
    return sample_posterior([&](const Eigen::VectorXd& x) { return likelihood.anew(x) + likelihood.log_prior(x); },
                            theta, 2.0 * gram(whitening(information, 1e-15)), config.n_draws, config.seed);
  }
  // sandwich by drop: holds whatever goes on within a drop
  const Eigen::MatrixXd of_curvature = inverse_curvature(likelihood, theta, by_impact);
  const Eigen::MatrixXd drops = likelihood.by_drop(by_impact);
  const auto m = static_cast<double>(drops.cols());
  return normal_draws(theta, congruence(of_curvature, gram(drops)) * (m / (m - 1.0)), config.n_draws, config.seed);
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
  return congruence(jacobian.transpose(), posterior.covariance.topLeftCorner(n, n));
}

void describe_law(MemoryFit& fit, const LawModel& model, const Posterior& posterior,
                  const std::vector<NodeEstimate>& nodes, double v_middle) {
  const Eigen::Index n_law = model.n_parameters();
  const Eigen::VectorXd q = posterior.mean.head(n_law);
  const std::vector<std::string> names = model.names();
  for (std::size_t i = 0; i < names.size(); ++i)
    fit.parameters.push_back({names[i], estimate_of(posterior, [&](const Eigen::VectorXd& theta) {
                                return model.reported(theta.head(n_law))[static_cast<Eigen::Index>(i)];
                              })});
  const Eigen::MatrixXd covariance = covariance_of(posterior, model.reported_jacobian(q));
  mark_identified(fit.parameters, model, correlation_of(covariance), v_middle,
                  model.eps(std::span(&v_middle, 1), q)[0]);
  fit.covariance = to_matrix(covariance);
  const auto eps_at = [&](double v) {
    return [&, v](const Eigen::VectorXd& theta) { return model.eps(std::span(&v, 1), theta.head(n_law))[0]; };
  };
  for (const NodeEstimate& node : nodes) fit.nodes.push_back({node.v_mps, estimate_of(posterior, eps_at(node.v_mps))});
  fit.law = model.law(q);
}

/// What speaks against the model, in words; empty where nothing does.
std::vector<Note> objections(const MemoryFit& fit) {
  constexpr double kRejected = 0.01;
  std::vector<Note> found;
  const auto test = [&](NoteKind kind, double p_value) {
    if (p_value <= kRejected) found.push_back({kind, {p_value}});
  };
  if (fit.loglik_independent && fit.loglik < *fit.loglik_independent) found.push_back({NoteKind::memory_unlikelier});
  if (fit.anderson_darling) test(NoteKind::memory_transforms, fit.anderson_darling->p_value);
  test(NoteKind::memory_mechanism, fit.mechanism.p_value);
  test(NoteKind::memory_by_speed, fit.by_speed.p_value);
  if (fit.between_drops) test(NoteKind::memory_between_drops, fit.between_drops->p_value);
  return found;
}

/// Fills in what the parameters say, how well they are known, and whether the model may be believed.
/// @param found     where the likelihood has its maximum and its plan
/// @param nodes     at whose speeds eps(v) is reported
/// @param v_middle  of all samples [m/s]
void describe(MemoryFit& fit, const MemoryLikelihood& likelihood, const Found& found, const MemoryFitConfig& config,
              const std::vector<NodeEstimate>& nodes, double v_middle) {
  const Eigen::VectorXd& theta = found.maximum.x;
  const Eigen::MatrixXd& scores = found.scores;
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
    fit.objections = {{NoteKind::memory_without_errors}};
    return;
  }
  describe_law(fit, likelihood.model(), posterior, nodes, v_middle);
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
    const ModelTests tests = tests_by_drawing(likelihood, theta, gram(of_fitted) + likelihood.prior_information(theta),
                                              z, config.n_goodness, config.seed);
    fit.anderson_darling = tests.anderson_darling;
    if (fit.n_drops > 1) fit.between_drops = tests.between_drops;
    for (std::size_t j = 0; tests.score_p && j < tested.size(); ++j) tested[j]->p_value = (*tests.score_p)[j];
  }
  fit.objections = objections(fit);
  fit.holds = fit.objections.empty();
}

}  // namespace

MemoryFit fit_memory(const RestitutionSamples& samples, const LawFit& independent, const MemoryFitConfig& config) {
  MemoryFit fit;
  if (config.kind == LawKind::series && config.orders.size() > kMostMemoryLawParameters)
    throw InvalidArgument("orders of the series: with memory at most " + std::to_string(kMostMemoryLawParameters));
  if (!independent.law || !independent.scatter) {
    fit.objections = {{NoteKind::memory_without_law}};
    return fit;
  }
  const Chains chains = chains_of(samples, independent.outliers, *independent.law);
  if (!samples.empty()) fit.ball = samples.front().conditions.ball;
  fit.n = chains.n_impacts;
  fit.n_drops = chains.n_drops;
  fit.n_chains = chains.chains.size();
  std::size_t longest = 0;
  for (const Chain& chain : chains.chains) longest = std::max(longest, chain.impacts.size());
  if (fit.n < kFewestImpacts || longest < kShortestLongest) {
    fit.objections = {
        {NoteKind::memory_too_few, {static_cast<double>(kFewestImpacts), static_cast<double>(kShortestLongest)}}};
    return fit;
  }
  const std::vector<double> speeds = speeds_of(samples);
  const LawModel model = make_law_model(config.kind, config.orders, speeds);
  MemoryLikelihood likelihood(chains, model);
  Eigen::VectorXd start;
  if (chains.n_impacts > 2 * kFewImpacts) {
    // near the maximum by a part of the chains: of all, each step takes long
    const Chains few = thinned_chains(chains, kFewImpacts);
    MemoryLikelihood part(few, model);
    start = first_theta(part, independent);
    const Found there = search(part, start);
    if (std::isfinite(there.maximum.loglik)) start = there.maximum.x;
  } else {
    start = first_theta(likelihood, independent);
  }
  const Found found = search(likelihood, start);
  if (!succeeded(found)) {
    fit.status = FitStatus::not_converged;
    fit.objections = {{NoteKind::memory_not_converged}};
    return fit;
  }
  fit.loglik_independent = loglik_independent(chains, independent);
  fit.status = FitStatus::ok;
  describe(fit, likelihood, found, config, independent.nodes, median(speeds));
  return fit;
}

Roughness equivalent_surfaces(const Estimate& q, double inertia_factor) {
  if (!(inertia_factor > 0.0 && inertia_factor <= 1.0))
    throw InvalidArgument("inertia factor J/(m R^2) = " + std::to_string(inertia_factor) + ": must be in (0, 1]");
  Roughness r;
  r.q = q;
  r.inertia_factor = inertia_factor;
  r.s2_no_slip = q.value * (1.0 + inertia_factor);
  r.s2_frictionless = q.value * inertia_factor;
  r.rms_tilt_no_slip_deg = std::sqrt(2.0 * r.s2_no_slip) * 180.0 / std::numbers::pi;
  r.n_constant_radii = 2.0 / r.s2_no_slip;
  r.lambda_exponential = r.s2_no_slip;
  r.width_uniform_1e6 = 4e6 * square(r.s2_no_slip) / std::numbers::pi;
  return r;
}

RoughnessResult measure_roughness(const RestitutionSamples& samples, const RoughnessConfig& config) {
  check_options(config);
  RoughnessResult result;
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  const RestitutionSamples& used = *part;
  with_threads(config.n_threads, [&] {
    LawFitConfig start;
    start.intervals = IntervalMethod::covariance;
    start.seed = config.seed;
    const LawFit independent = fit_law(used, start);
    MemoryFitConfig memory;
    memory.seed = config.seed;
    memory.n_goodness = config.n_goodness;
    result.memory = fit_memory(used, independent, memory);
    if (!independent.outliers.empty()) left_out.n["outlier"] = independent.outliers.size();
  });
  result.n_left_out = left_out.n;
  return result;
}

Estimate leak_of(const MemoryFit& memory) {
  const auto reversed = [](std::optional<Interval>& i) {
    if (i) i = Interval{1.0 - i->hi, 1.0 - i->lo};
  };
  Estimate leak = memory.keep;
  leak.value = 1.0 - leak.value;
  reversed(leak.ci68);
  reversed(leak.ci95);
  return leak;
}

}  // namespace bouncelab::fit
