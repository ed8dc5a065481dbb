// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "law/maximise.hpp"
#include "memory/memory_likelihood.hpp"
#include "memory/memory_result.hpp"
#include "memory/memory_tests.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewestImpacts = 60, kShortestLongest = 10;
constexpr std::size_t kFewImpacts = 8000;

std::vector<double> speeds_of(const RestitutionSamples& samples) {
  std::vector<double> v;
  for (const RestitutionSample& s : samples) v.push_back(s.v_mps);
  return v;
}

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
  if (model.kind == LawKind::viscoelastic) {
    const double v = chains.chains.front().impacts.front().v_mps;
    theta[0] = log_gamma_through(v, restitution(*independent.law, v));
  } else if (model.kind == LawKind::constant) {
    theta[0] = restitution(*independent.law, chains.chains.front().impacts.front().v_mps);
  } else {
    for (Eigen::Index j = 0; j < n_law; ++j)
      theta[j] = restitution(*independent.law, model.node_v_mps[static_cast<std::size_t>(j)]);
  }
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
    const Eigen::MatrixXd information = fitted * fitted.transpose() + likelihood.prior_information(theta);
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
  if (!samples.empty()) fit.ball = samples.front().conditions.ball;
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
    fit.message =
        "the search for the likeliest parameters did not converge: these fluctuations are not those of a "
        "rough ball's memory";
    return fit;
  }
  fit.loglik_independent = loglik_independent(chains, independent);
  fit.status = FitStatus::ok;
  describe(fit, likelihood, found.maximum.x, found.scores, config, speeds);
  return fit;
}

}  // namespace bouncelab::fit
