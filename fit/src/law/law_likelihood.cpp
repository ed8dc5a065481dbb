// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_likelihood.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::fit {
namespace {

// exp() of anything beyond is no scatter of a coefficient of restitution; keeps the search out of overflow
constexpr std::size_t kBlock = 4096;
constexpr std::size_t kMostLawParameters = 8;  // orders 2, 4, 5 ... 10
constexpr double kLogScaleMin = -30.0, kLogScaleMax = 3.0;

NormalLaplace normal_density(double d, double s, double tau) {
  const double variance = s * s + tau * tau;
  const double ratio = d * d / variance;
  return {-0.5 * (ratio + log(2.0 * std::numbers::pi * variance)), d / variance, (ratio - 1.0) * s * s / variance, 0.0};
}

double polynomial(const double* c, std::size_t n, double x) {
  double sum = 0.0;
  for (std::size_t k = n; k-- > 0;) sum = sum * x + c[k];
  return sum;
}

void add_powers(double value, double x, std::size_t n, double* sums) {
  for (std::size_t k = 0; k < n; ++k, value *= x) sums[k] += value;
}

}  // namespace

Eigen::Index ScatterFamily::n_parameters() const {
  return static_cast<Eigen::Index>(kind == ScatterKind::asymmetric_laplace ? 2 * n_terms : n_terms);
}

LawLikelihood::LawLikelihood(const LawData& data, const LawModel& model, const ScatterFamily& scatter)
    : data_(data), model_(model), scatter_(scatter), n_law_(model.n_parameters()) {
  for (const double v : data.v_mps) x_.push_back(log(v / scatter.v_ref_mps));
  for (const double tau : data.tau) inverse_tau_.push_back(1.0 / tau);
  if (model.is_linear()) {
    basis_ = model.jacobian(data.v_mps, Eigen::VectorXd::Ones(n_law_)).transpose();
  } else {
    basis_.resize(1, static_cast<Eigen::Index>(data.size()));
    for (std::size_t k = 0; k < data.size(); ++k) basis_(0, static_cast<Eigen::Index>(k)) = pow(data.v_mps[k], 0.1);
  }
}

double LawLikelihood::eps_of(const Eigen::VectorXd& theta, std::size_t k, double* row) const {
  const double* basis = basis_.col(static_cast<Eigen::Index>(k)).data();
  if (!model_.is_linear()) {
    const auto [eps, slope] = viscoelastic_of_log_gamma(theta[0], *basis);
    if (row) *row = slope;
    return eps;
  }
  double eps = 1.0;
  for (Eigen::Index i = 0; i < n_law_; ++i) eps += basis[i] * (theta[i] - 1.0);
  if (row) std::copy(basis, basis + n_law_, row);
  return eps;
}

LaplaceSides LawLikelihood::scales(const Eigen::VectorXd& theta, std::size_t k) const {
  const double* c = theta.data() + n_law_;
  const double log_below = polynomial(c, scatter_.n_terms, x_[k]);
  if (scatter_.kind != ScatterKind::asymmetric_laplace) {
    const double b = exp(std::clamp(log_below, kLogScaleMin, kLogScaleMax));
    return laplace_sides(b, b);
  }
  const double log_above = polynomial(c + scatter_.n_terms, scatter_.n_terms, x_[k]);
  const Pair b =
      exp(Pair{std::clamp(log_below, kLogScaleMin, kLogScaleMax), std::clamp(log_above, kLogScaleMin, kLogScaleMax)});
  return laplace_sides(b.first, b.second);
}

NormalLaplace LawLikelihood::density_at(double d, const LaplaceSides& sides, std::size_t k) const {
  return scatter_.kind == ScatterKind::normal ? normal_density(d, sides.b_below, data_.tau[k])
                                              : normal_laplace(d, sides, data_.tau[k], inverse_tau_[k]);
}

void LawLikelihood::add_score(const NormalLaplace& f, std::size_t k, const double* law_row, double* gradient) const {
  for (Eigen::Index i = 0; i < n_law_; ++i) gradient[i] += f.d_location * law_row[i];
  double* of_scales = gradient + n_law_;
  if (scatter_.kind == ScatterKind::asymmetric_laplace) {
    add_powers(f.d_log_below, x_[k], scatter_.n_terms, of_scales);
    add_powers(f.d_log_above, x_[k], scatter_.n_terms, of_scales + scatter_.n_terms);
  } else {
    add_powers(f.d_log_below + f.d_log_above, x_[k], scatter_.n_terms, of_scales);
  }
}

double LawLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!theta.allFinite()) return -HUGE_VAL;
  const std::optional<LaplaceSides> one_scale = scatter_.n_terms == 1 ? std::optional(scales(theta, 0)) : std::nullopt;
  // blocks of fixed size, added in order: the same sum for any number of threads
  const std::size_t n_blocks = (data_.size() + kBlock - 1) / kBlock;
  std::vector<double> sums(n_blocks, 0.0);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(gradient ? n_parameters() : 0, static_cast<Eigen::Index>(n_blocks));
  parallel_for(n_blocks, 0, [&](std::size_t block) {
    double* of_block = gradient ? gradients.col(static_cast<Eigen::Index>(block)).data() : nullptr;
    for (std::size_t k = block * kBlock; k < std::min(data_.size(), (block + 1) * kBlock); ++k) {
      std::array<double, kMostLawParameters> row;
      const double residual = data_.eps[k] - eps_of(theta, k, of_block ? row.data() : nullptr);
      const NormalLaplace f = density_at(residual, one_scale ? *one_scale : scales(theta, k), k);
      sums[block] += f.log_density;
      if (of_block) add_score(f, k, row.data(), of_block);
    }
  });
  double sum = 0.0;
  for (const double s : sums) sum += s;
  if (gradient) {
    gradient->setZero(n_parameters());
    for (std::size_t block = 0; block < n_blocks; ++block) *gradient += gradients.col(static_cast<Eigen::Index>(block));
  }
  return sum - asymmetry_penalty(theta, gradient);
}

double LawLikelihood::asymmetry_penalty(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (scatter_.kind != ScatterKind::asymmetric_laplace) return 0.0;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  double sum = 0.0;
  for (Eigen::Index k = n_law_; k < n_law_ + n_terms; ++k) {
    const double d = theta[k + n_terms] - theta[k], r = 1.0 / (1.0 + d * d);
    sum += 0.5 * (d * d - 1.0 + r);
    if (!gradient) continue;
    const double slope = d - d * r * r;
    (*gradient)[k] += slope;
    (*gradient)[k + n_terms] -= slope;
  }
  return sum;
}

void LawLikelihood::add_penalty_curvature(const Eigen::VectorXd& theta, Eigen::MatrixXd& information) const {
  if (scatter_.kind != ScatterKind::asymmetric_laplace) return;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  for (Eigen::Index k = n_law_; k < n_law_ + n_terms; ++k) {
    const double d = theta[k + n_terms] - theta[k], r = 1.0 / (1.0 + d * d);
    const double curvature = 1.0 - (1.0 - 3.0 * d * d) * r * r * r;
    information(k, k) += curvature;
    information(k + n_terms, k + n_terms) += curvature;
    information(k, k + n_terms) -= curvature;
    information(k + n_terms, k) -= curvature;
  }
}

NormalLaplace LawLikelihood::density(const Eigen::VectorXd& theta, std::size_t k) const {
  return density_at(data_.eps[k] - eps_of(theta, k, nullptr), scales(theta, k), k);
}

double LawLikelihood::probability_below(const Eigen::VectorXd& theta, std::size_t k) const {
  const LaplaceSides b = scales(theta, k);
  const double d = data_.eps[k] - eps_of(theta, k, nullptr), tau = data_.tau[k];
  if (scatter_.kind == ScatterKind::normal)
    return 0.5 * erfc(-d / std::sqrt(2.0 * (b.b_below * b.b_below + tau * tau)));
  return normal_laplace_cdf(d, b.b_below, b.b_above, tau);
}

Information3 LawLikelihood::information_of(const Eigen::VectorXd& theta, std::size_t k) const {
  const LaplaceSides b = scales(theta, k);
  const double tau = data_.tau[k];
  if (scatter_.kind != ScatterKind::normal) return normal_laplace_information(b.b_below, b.b_above, tau);
  const double variance = b.b_below * b.b_below + tau * tau, share = b.b_below * b.b_below / variance;
  return {1.0 / variance, 0.0, 0.0, 2.0 * share * share, 0.0, 0.0};
}

Eigen::MatrixXd LawLikelihood::information(const Eigen::VectorXd& theta) const {
  constexpr std::size_t kEnough = 600;  // a stratified mean over so many speeds is good to a percent
  const std::size_t stride = std::max<std::size_t>(1, data_.size() / kEnough);
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  const bool two_sided = scatter_.kind == ScatterKind::asymmetric_laplace;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_parameters(), n_parameters());
  Eigen::VectorXd row(n_law_);
  std::size_t n = 0;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride, ++n) {
    const Information3 info = information_of(theta, k);
    Eigen::VectorXd powers(n_terms);
    for (Eigen::Index i = 0; i < n_terms; ++i) powers[i] = power(x_[k], static_cast<int>(i));
    // predictors (rows): location, log b_below, log b_above
    Eigen::MatrixXd design = Eigen::MatrixXd::Zero(3, n_parameters());
    eps_of(theta, k, row.data());
    design.row(0).head(n_law_) = row.transpose();
    design.row(1).segment(n_law_, n_terms) = powers.transpose();
    design.row(2).segment(n_law_ + (two_sided ? n_terms : 0), n_terms) = powers.transpose();
    Eigen::Matrix3d j;
    j << info.ll, info.lb, info.la, info.lb, info.bb, info.ba, info.la, info.ba, info.aa;
    sum.noalias() += design.transpose() * j * design;
  }
  sum *= static_cast<double>(data_.size()) / static_cast<double>(n);
  add_penalty_curvature(theta, sum);
  return sum;
}

Eigen::MatrixXd LawLikelihood::scores_by_drop(const Eigen::VectorXd& theta) const {
  const std::size_t n_drops = data_.drop.empty() ? 0 : *std::max_element(data_.drop.begin(), data_.drop.end()) + 1;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(n_drops));
  Eigen::VectorXd row(n_law_);
  for (std::size_t k = 0; k < data_.size(); ++k) {
    const double residual = data_.eps[k] - eps_of(theta, k, row.data());
    add_score(density_at(residual, scales(theta, k), k), k, row.data(),
              scores.col(static_cast<Eigen::Index>(data_.drop[k])).data());
  }
  return scores;
}

ScatterModel LawLikelihood::scatter_model(const Eigen::VectorXd& theta) const {
  const double* c = theta.data() + n_law_;
  ScatterModel result;
  result.v_ref_mps = scatter_.v_ref_mps;
  result.log_below.assign(c, c + scatter_.n_terms);
  if (scatter_.kind == ScatterKind::asymmetric_laplace) c += scatter_.n_terms;
  result.log_above.assign(c, c + scatter_.n_terms);
  return result;
}

}  // namespace bouncelab::fit
