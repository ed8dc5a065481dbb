// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_with_memory.hpp"
#include "law/goodness.hpp"
#include "law/intervals.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kFreedom = 5.0;

/// R with R R^T the covariance, in whatever units.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  return whitening(gram(whitening(covariance, 1e-15)), 1e-12);
}

/// One round: draws about a centre, weighed by the density.
Posterior round_of(const LogDensity& log_density, const Eigen::VectorXd& centre, const Eigen::MatrixXd& spread,
                   std::size_t n, std::uint64_t seed, std::uint64_t round) {
  Posterior result;
  const Eigen::Index p = centre.size(), columns = static_cast<Eigen::Index>(n);
  result.draws.resize(p, columns);
  Eigen::VectorXd log_weight(columns);
  parallel_for(n, 0, [&](std::size_t k) {
    Random random(seed, RandomStream::bootstrap, (round << 32U) + k);
    Eigen::VectorXd z(p);
    double chi2 = 0.0;
    for (double& value : z) value = random.normal();
    for (int i = 0; i < static_cast<int>(kFreedom); ++i) chi2 += square(random.normal());
    const Eigen::VectorXd y = z / std::sqrt(chi2 / kFreedom);
    const auto column = static_cast<Eigen::Index>(k);
    result.draws.col(column) = centre + product(spread, y);
    const double log_proposal = -0.5 * (kFreedom + static_cast<double>(p)) * log1p(y.squaredNorm() / kFreedom);
    const double value = log_density(result.draws.col(column));
    log_weight[column] = std::isfinite(value) ? value - log_proposal : -HUGE_VAL;
  });
  const double highest = log_weight.maxCoeff();
  result.weights.resize(columns);
  for (Eigen::Index k = 0; k < columns; ++k) result.weights[k] = exp(log_weight[k] - highest);
  const double cut = result.weights.mean() * std::sqrt(static_cast<double>(n));
  result.weights = result.weights.cwiseMin(cut);
  result.weights /= result.weights.sum();
  result.effective = 1.0 / result.weights.squaredNorm();
  result.mean = product(result.draws, result.weights);
  const Eigen::MatrixXd about = result.draws.colwise() - result.mean;
  result.covariance = product(about * result.weights.asDiagonal(), about.transpose());
  return result;
}

}  // namespace

Interval interval_of(const Eigen::VectorXd& values, const Eigen::VectorXd& weights, double probability) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
  const auto quantile = [&](double level) {
    // each weight at its middle, linear between
    double sum = 0.0, before = 0.0, value_before = values[order.front()];
    for (const Eigen::Index k : order) {
      const double middle = sum + 0.5 * weights[k];
      if (middle >= level) {
        const double share = middle > before ? (level - before) / (middle - before) : 1.0;
        return value_before + share * (values[k] - value_before);
      }
      sum += weights[k];
      before = middle;
      value_before = values[k];
    }
    return value_before;
  };
  const double tail = 0.5 * (1.0 - probability);
  return {quantile(tail), quantile(1.0 - tail)};
}

Posterior normal_draws(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, std::size_t n_draws,
                       std::uint64_t seed) {
  Posterior result;
  const auto n = static_cast<Eigen::Index>(n_draws);
  result.mean = mean;
  result.covariance = covariance;
  result.effective = static_cast<double>(n_draws);
  result.weights = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n_draws));
  result.draws.resize(mean.size(), n);
  const Eigen::MatrixXd spread = root_of(covariance);
  for (Eigen::Index k = 0; k < n; ++k) {
    Random random(seed, RandomStream::bootstrap, (std::uint64_t{3} << 40U) + static_cast<std::uint64_t>(k));
    Eigen::VectorXd z(mean.size());
    for (double& value : z) value = random.normal();
    result.draws.col(k) = mean + product(spread, z);
  }
  // exactly the mean asked for: what is reported has no error of drawing
  const Eigen::VectorXd shift = product(result.draws, result.weights) - mean;
  result.draws.colwise() -= shift;
  return result;
}

Posterior sample_posterior(const LogDensity& log_density, const Eigen::VectorXd& centre,
                           const Eigen::MatrixXd& covariance, std::size_t n_draws, std::uint64_t seed) {
  constexpr int kMostRounds = 5;
  constexpr double kEnough = 0.15;  // of the draws: the round's mean and covariance are good enough to draw by
  Eigen::VectorXd about = centre;
  Eigen::MatrixXd spread = covariance;
  for (int round = 0; round < kMostRounds; ++round) {
    const Posterior here =
        round_of(log_density, about, root_of(spread), n_draws / 3, seed, static_cast<std::uint64_t>(round));
    const auto n = static_cast<double>(here.draws.cols());
    const double few = static_cast<double>(4 * about.size());
    about = here.mean;
    // of few effective draws the covariance is no guide: the old one, halved or doubled, shares
    const double trust = here.effective / (here.effective + few);
    spread = (trust * here.covariance + (1.0 - trust) * spread).eval();
    if (round > 0 && here.effective > kEnough * n) break;
  }
  return round_of(log_density, about, root_of(spread), n_draws, seed, kMostRounds);
}

namespace {

/// Impacts that the test is made of at most.
constexpr std::size_t kMostImpacts = 4000;

/// A chain as the model would have it: the first speed and all errors as in `like`; the first reservoir, impacts
/// (restitution_with_memory), heights of contacts and timing errors drawn. Heights are exponential and independent.
/// @param height_sd_m  their standard deviation, Chains::height_sd_m
Chain draw_chain(const Chain& like, const RestitutionLaw& law, const MemoryParameters<double>& parameters,
                 double height_sd_m, Random& random) {
  Chain chain = like;
  const auto eps = [&](double v_mps) { return restitution(law, v_mps); };
  const auto draw_height_m = [&] { return -height_sd_m * random.exponential(); };
  const auto draw_timing = [&](double variance) { return std::sqrt(variance) * random.normal(); };
  const ChainImpact& first = like.impacts.front();
  double w = (2.0 * parameters.q * like.s_before + parameters.release) * random.exponential(), v = first.v_mps;
  double height_before = draw_height_m(), height = draw_height_m();
  double timing_before = draw_timing(first.timing_before), timing = draw_timing(first.timing);
  // errors are those of `like`: the drawn speeds differ too little to scale them anew
  for (ChainImpact& m : chain.impacts) {
    m.v_mps = v + m.height_mps * (height - height_before) + timing - timing_before;
    const double z1 = random.normal(), z2 = random.normal();
    const double eps_drawn = restitution_with_memory(v, eps, parameters.q, z1, z2, w), v_after = eps_drawn * v;
    w *= kept(parameters, m);
    // a next contact that is higher by this, in speed, is met earlier and at twice as much less
    const double height_next = draw_height_m(), timing_next = draw_timing(m.timing_after);
    const double rise = m.height_mps / eps_drawn * (height_next - height);
    m.v_after_mps = v_after - rise + timing_next - timing;
    v = v_after - 2.0 * rise;
    height_before = height;
    height = height_next;
    timing_before = timing;
    timing = timing_next;
  }
  return chain;
}

}  // namespace

double two_sided(double z) { return erfc(std::abs(z) * 0.70710678118654752); }

MemoryTest score_test(const MemoryLikelihood& likelihood, const Eigen::MatrixXd& scores, Eigen::Index tested) {
  const Eigen::MatrixXd fitted = scores.topRows(likelihood.n_parameters());
  const Eigen::VectorXd own = scores.row(tested).transpose();
  const Eigen::MatrixXd white = whitening(gram(fitted), 1e-14);
  const Eigen::VectorXd of_fitted = product(white, transposed_product(white, product(fitted, own)));
  const Eigen::MatrixXd rest = own.transpose() - transposed_product(of_fitted, fitted);
  const Eigen::MatrixXd by_drop = likelihood.by_drop(rest);
  const auto n = static_cast<double>(by_drop.cols());
  const bool enough = likelihood.chains().n_drops >= kFewestDrops;
  const double variance = enough ? by_drop.squaredNorm() * n / (n - 1.0) : rest.squaredNorm();
  MemoryTest test;
  if (!(variance > 0.0)) return test;
  test.z = rest.sum() / std::sqrt(variance);
  test.p_value = enough ? 2.0 * student_t_below(-std::abs(test.z), n - 1.0) : two_sided(test.z);
  return test;
}

double drops_over_impacts(const MemoryLikelihood& likelihood, const Eigen::MatrixXd& scores,
                          const Eigen::MatrixXd& information) {
  const Eigen::MatrixXd drops = likelihood.by_drop(scores);
  const auto n = static_cast<double>(drops.cols());
  if (n < 2.0) return 0.0;
  // about their mean: it is zero of what was fitted, and not of a sample that was drawn
  const Eigen::MatrixXd white =
      transposed_product(whitening(information, 1e-9), drops.colwise() - drops.rowwise().mean());
  return white.squaredNorm() * n / (n - 1.0) / static_cast<double>(scores.rows());
}

ModelTests tests_by_drawing(const MemoryLikelihood& likelihood, const Eigen::VectorXd& theta,
                            const Eigen::MatrixXd& information, const std::array<double, kTestedParameters>& z,
                            std::size_t n_replicates, std::uint64_t seed) {
  const Chains design = thinned_chains(likelihood.chains(), kMostImpacts);
  const LawModel& model = likelihood.model();
  const RestitutionLaw law = model.law(theta.head(model.n_parameters()));
  const MemoryParameters<double> parameters = likelihood.parameters(theta);
  // what a step finds has the error of all impacts, of which those of the design are a share
  const double share = static_cast<double>(design.n_impacts) / static_cast<double>(likelihood.chains().n_impacts);
  const double height_sd_m = design.height_sd_m(parameters.q);
  const Eigen::MatrixXd white = whitening(information, 1e-9);

  /// What is compared, of the impacts observed or drawn.
  struct Statistics {
    double a2 = 0.0, drops = 0.0;
    std::array<double, kTestedParameters> z{};
  };
  const auto statistics = [&](MemoryLikelihood& those, Random* random) {
    Statistics result;
    those.plan_at(theta);
    const Eigen::MatrixXd scores = those.scores_by_impact(theta);
    const Eigen::MatrixXd fitted = scores.topRows(theta.size());
    result.drops = drops_over_impacts(those, fitted, gram(fitted) + those.prior_information(theta));
    if (random == nullptr) {
      result.a2 = anderson_darling(those.transforms(theta));
      return result;
    }
    for (std::size_t j = 0; j < result.z.size(); ++j)
      result.z[j] = score_test(those, scores, theta.size() + static_cast<Eigen::Index>(j)).z;
    Eigen::VectorXd others(theta.size());
    for (double& x : others) x = random->normal();
    const Eigen::VectorXd in_white =
        transposed_product(white, fitted.rowwise().sum()) + std::sqrt(1.0 - share) * others;
    result.a2 = anderson_darling(those.transforms(theta + product(white, in_white)));
    return result;
  };

  MemoryLikelihood observed(design, model);
  const Statistics here = statistics(observed, nullptr);
  std::vector<Statistics> drawn(n_replicates);
  parallel_for(n_replicates, 0, [&](std::size_t i) {
    Random random(seed, RandomStream::bootstrap, (std::uint64_t{2} << 32U) + i);
    Chains chains = design;
    for (Chain& chain : chains.chains) chain = draw_chain(chain, law, parameters, height_sd_m, random);
    MemoryLikelihood again(chains, model);
    drawn[i] = statistics(again, &random);
  });

  const auto p_of = [&](const auto& is_beyond) {
    const auto n_beyond = std::count_if(drawn.begin(), drawn.end(), is_beyond);
    return (1.0 + static_cast<double>(n_beyond)) / (1.0 + static_cast<double>(n_replicates));
  };
  ModelTests tests;
  tests.anderson_darling = {here.a2, p_of([&](const Statistics& s) { return !(s.a2 < here.a2); }), n_replicates};
  tests.between_drops = {here.drops, p_of([&](const Statistics& s) { return !(s.drops < here.drops); })};
  if (design.n_impacts < likelihood.chains().n_impacts) return tests;
  // of few drops a score is neither normal nor about zero
  tests.score_p.emplace();
  for (std::size_t j = 0; j < z.size(); ++j) {
    double mean = 0.0;
    for (const Statistics& s : drawn) mean += s.z[j] / static_cast<double>(n_replicates);
    (*tests.score_p)[j] = p_of([&](const Statistics& s) { return !(std::abs(s.z[j] - mean) < std::abs(z[j] - mean)); });
  }
  return tests;
}

}  // namespace bouncelab::fit
