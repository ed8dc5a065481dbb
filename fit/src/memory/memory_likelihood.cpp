// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/memory_likelihood.hpp"

#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::fit {
namespace {

/// Relative step for the slope of the law.
constexpr double kStep = 1e-3;
constexpr double kSlipSd = 1.2527629684953681;  // log(7/2)

std::vector<double> speeds_of(const Chain& chain, double factor) {
  std::vector<double> v;
  for (const ChainImpact& m : chain.impacts) v.push_back(factor * m.v_mps);
  return v;
}

LawRows rows_of(const Chain& chain, const LawModel& model, const Eigen::VectorXd& q) {
  const std::vector<double> v = speeds_of(chain, 1.0), up = speeds_of(chain, 1.0 + kStep),
                            down = speeds_of(chain, 1.0 - kStep);
  Eigen::MatrixXd slope = (model.jacobian(up, q) - model.jacobian(down, q)).transpose();
  for (Eigen::Index k = 0; k < slope.cols(); ++k) slope.col(k) /= 2.0 * kStep * v[static_cast<std::size_t>(k)];
  return {model.jacobian(v, q).transpose(), slope};
}

}  // namespace

MemoryLikelihood::MemoryLikelihood(const Chains& chains, const LawModel& model)
    : chains_(chains), model_(model), n_law_(model.n_parameters()) {
  if (!model.is_linear()) return;
  for (const Chain& chain : chains.chains) linear_.push_back(rows_of(chain, model, Eigen::VectorXd::Ones(n_law_)));
}

std::vector<LawAt<double>> MemoryLikelihood::law_values(std::size_t chain, const Eigen::VectorXd& theta) const {
  const Chain& c = chains_.chains[chain];
  const Eigen::VectorXd q = theta.head(n_law_);
  Eigen::RowVectorXd eps, slope;
  if (model_.is_linear()) {
    const Eigen::RowVectorXd lost = (q.array() - 1.0).matrix().transpose();
    eps = (lost * linear_[chain].eps).array() + 1.0;
    slope = lost * linear_[chain].slope;
  } else {
    eps = model_.eps(speeds_of(c, 1.0), q).transpose();
    slope = (model_.eps(speeds_of(c, 1.0 + kStep), q) - model_.eps(speeds_of(c, 1.0 - kStep), q)).transpose();
    for (Eigen::Index k = 0; k < slope.size(); ++k)
      slope[k] /= 2.0 * kStep * c.impacts[static_cast<std::size_t>(k)].v_mps;
  }
  std::vector<LawAt<double>> law;
  for (Eigen::Index k = 0; k < eps.size(); ++k) law.push_back({eps[k], slope[k]});
  return law;
}

MemoryParameters<double> MemoryLikelihood::parameters(const Eigen::VectorXd& theta) const {
  const double q = exp(theta[n_law_]);
  return {q,
          theta[n_law_ + 1],
          exp(theta[n_law_ + 2]) - first_at_rest_m2ps2(q),
          {theta[n_law_ + 3], theta[n_law_ + 4]},
          1.0,
          0.0};
}

void MemoryLikelihood::plan_at(const Eigen::VectorXd& theta) {
  plans_.assign(chains_.chains.size(), {});
  const MemoryParameters<double> p = parameters(theta);
  parallel_for(plans_.size(), 0, [&](std::size_t c) { filter(c, p).plan(law_values(c, theta), plans_[c]); });
}

void MemoryLikelihood::score(std::size_t chain, const Eigen::VectorXd& theta, double& loglik, Eigen::VectorXd* gradient,
                             Eigen::MatrixXd* by_impact) const {
  LawRows own;
  if (!model_.is_linear()) own = rows_of(chains_.chains[chain], model_, theta.head(n_law_));
  const LawRows& rows = model_.is_linear() ? linear_[chain] : own;
  std::vector<LawAt<Jet>> law;
  for (const LawAt<double>& at : law_values(chain, theta)) {
    const Eigen::Index i = std::ssize(law);
    law.push_back({Jet(at.eps), Jet(at.slope)});
    law.back().eps.v.head(n_law_) = rows.eps.col(i);
    law.back().slope.v.head(n_law_) = rows.slope.col(i);
  }
  const MemoryParameters<double> values = parameters(theta);
  const int n = static_cast<int>(n_law_);
  MemoryParameters<Jet> p{Jet(values.q),       Jet(values.keep),
                          Jet(values.release), {Jet(values.slip[0]), Jet(values.slip[1])},
                          Jet(values.ratio),   Jet(values.power)};
  p.q.v[n] = values.q;
  p.keep.v[n + 1] = 1.0;
  p.release.v[n] = -first_at_rest_m2ps2(values.q);
  p.release.v[n + 2] = exp(theta[n_law_ + 2]);
  for (std::size_t j = 0; j < kSlipTimes; ++j) p.slip[j].v[n + 3 + static_cast<int>(j)] = 1.0;
  if (by_impact) {
    const int tested = static_cast<int>(n_parameters());
    p.ratio.v[tested] = p.power.v[tested + 1] = 1.0;
  }
  std::vector<Jet> densities;
  const Jet sum = filter(chain, p).loglik(law, plans_[chain], by_impact ? &densities : nullptr);
  loglik = sum.a;
  if (gradient) *gradient = sum.v.head(n_parameters());
  if (!by_impact) return;
  const Eigen::Index n_rows = n_parameters() + kTestedParameters;
  by_impact->resize(n_rows, static_cast<Eigen::Index>(densities.size()));
  for (std::size_t k = 0; k < densities.size(); ++k)
    by_impact->col(static_cast<Eigen::Index>(k)) = densities[k].v.head(n_rows);
}

double MemoryLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  const std::size_t n = chains_.chains.size();
  std::vector<double> logliks(n, 0.0);
  std::vector<Eigen::VectorXd> gradients(gradient ? n : 0);
  const MemoryParameters<double> p = parameters(theta);
  parallel_for(n, 0, [&](std::size_t c) {
    if (gradient)
      score(c, theta, logliks[c], &gradients[c], nullptr);
    else
      logliks[c] = filter(c, p).loglik(law_values(c, theta), plans_[c]);
  });
  double sum = log_prior(theta);
  for (const double one : logliks) sum += one;
  if (!gradient) return sum;
  *gradient = prior_gradient(theta);
  for (const Eigen::VectorXd& one : gradients) *gradient += one;
  return sum;
}

double MemoryLikelihood::log_prior(const Eigen::VectorXd& theta) const {
  if (!(theta[index_of_first()] < log(chains_.least_s_before))) return -HUGE_VAL;
  return -0.5 * theta.tail(kSlipTimes).squaredNorm() / square(kSlipSd) - log1p(rest_over_first_squared(theta));
}

Eigen::VectorXd MemoryLikelihood::prior_gradient(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd gradient = gradient_by_first(theta);
  gradient.tail(kSlipTimes) = -theta.tail(kSlipTimes) / square(kSlipSd);
  return gradient;
}

Eigen::MatrixXd MemoryLikelihood::prior_information(const Eigen::VectorXd& theta) const {
  const Eigen::VectorXd by_first = gradient_by_first(theta);
  Eigen::MatrixXd information = by_first * by_first.transpose();
  information.diagonal().tail(kSlipTimes).array() += 1.0 / square(kSlipSd);
  return information;
}

Eigen::VectorXd MemoryLikelihood::gradient_by_first(const Eigen::VectorXd& theta) const {
  const double x = rest_over_first_squared(theta);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n_parameters());
  gradient[index_of_first()] = 2.0 * x / (1.0 + x);
  gradient[index_of_q()] = -gradient[index_of_first()];
  return gradient;
}

double MemoryLikelihood::rest_over_first_squared(const Eigen::VectorXd& theta) const {
  return square(first_at_rest_m2ps2(exp(theta[index_of_q()] - theta[index_of_first()])));
}

Eigen::MatrixXd MemoryLikelihood::scores_by_impact(const Eigen::VectorXd& theta) const {
  std::vector<Eigen::MatrixXd> by_chain(chains_.chains.size());
  parallel_for(by_chain.size(), 0, [&](std::size_t c) {
    double ignored = 0.0;
    score(c, theta, ignored, nullptr, &by_chain[c]);
  });
  Eigen::MatrixXd all(n_parameters() + kTestedParameters, static_cast<Eigen::Index>(chains_.n_impacts));
  Eigen::Index begin = 0;
  for (const Eigen::MatrixXd& one : by_chain) {
    all.middleCols(begin, one.cols()) = one;
    begin += one.cols();
  }
  return all;
}

Eigen::MatrixXd MemoryLikelihood::by_drop(const Eigen::MatrixXd& scores_by_impact) const {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(scores_by_impact.rows(), static_cast<Eigen::Index>(chains_.n_drops));
  Eigen::Index begin = 0;
  for (const Chain& chain : chains_.chains) {
    const auto n = static_cast<Eigen::Index>(chain.impacts.size());
    columns.col(static_cast<Eigen::Index>(chain.drop)) += scores_by_impact.middleCols(begin, n).rowwise().sum();
    begin += n;
  }
  return columns;
}

double MemoryLikelihood::anew(const Eigen::VectorXd& theta) const {
  std::vector<double> result(chains_.chains.size());
  const MemoryParameters<double> p = parameters(theta);
  parallel_for(result.size(), 0, [&](std::size_t c) {
    FilterPlan plan;
    result[c] = filter(c, p).plan(law_values(c, theta), plan);
  });
  double sum = 0.0;
  for (const double one : result) sum += one;
  return sum;
}

std::vector<double> MemoryLikelihood::transforms(const Eigen::VectorXd& theta) const {
  std::vector<std::vector<double>> by_chain(chains_.chains.size());
  const MemoryParameters<double> p = parameters(theta);
  parallel_for(by_chain.size(), 0, [&](std::size_t c) {
    FilterPlan ignored;
    filter(c, p).plan(law_values(c, theta), ignored, &by_chain[c]);
  });
  std::vector<double> all;
  for (const std::vector<double>& one : by_chain) all.insert(all.end(), one.begin(), one.end());
  return all;
}

}  // namespace bouncelab::fit
