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
// Of bounces that are lost: the ball hit something else, or an impact was missed. Their eps may be anything from 0
// to 2.
constexpr double kLostShare = 0.01;
constexpr double kLostDensity = kLostShare / 2.0 / (1.0 - kLostShare);  // against one that is not
constexpr double kPrecisionOfAsymmetry = 4.0;  // of the log ratio of the sides: a factor 1.6 is one standard deviation
constexpr double kPrecisionOfRatio = 0.25;     // of rho: a factor 7 either way is one standard deviation

NormalLaplace normal_density(double d, double s, double tau) {
  const double variance = s * s + tau * tau;
  const double ratio = d * d / variance;
  return {-0.5 * (ratio + log(2.0 * std::numbers::pi * variance)), d / variance, (ratio - 1.0) * s * s / variance, 0.0,
          0.0};
}

double polynomial(const double* c, std::size_t n, double x) {
  double sum = 0.0;
  for (std::size_t k = n; k-- > 0;) sum = sum * x + c[k];
  return sum;
}

void add_powers(double value, double x, std::size_t n, double* sums) {
  for (std::size_t k = 0; k < n; ++k, value *= x) sums[k] += value;
}

constexpr std::size_t kDrops = 16;  // in a block of parallel work
std::size_t blocks_of_drops(std::size_t n_drops) { return (n_drops + kDrops - 1) / kDrops; }

std::vector<std::vector<std::size_t>> samples_by_drop(const std::vector<std::size_t>& drop, std::size_t n_drops) {
  std::vector<std::vector<std::size_t>> samples(n_drops);
  for (std::size_t k = 0; k < drop.size(); ++k) samples[drop[k]].push_back(k);
  return samples;
}

}  // namespace

Eigen::Index ScatterFamily::n_parameters() const {
  return static_cast<Eigen::Index>((is_two_sided() ? 2 : 1) * n_terms + (kind == ScatterKind::normal_laplace ? 1 : 0));
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

LaplaceSides LawLikelihood::sides(const Eigen::VectorXd& theta, std::size_t k) const {
  const double* c = theta.data() + n_law_;
  const double log_below = polynomial(c, scatter_.n_terms, x_[k]);
  if (!scatter_.is_two_sided()) {
    const double b = exp(std::clamp(log_below, kLogScaleMin, kLogScaleMax));
    return laplace_sides(b, b);
  }
  const double log_above = polynomial(c + scatter_.n_terms, scatter_.n_terms, x_[k]);
  const Pair b =
      exp(Pair{std::clamp(log_below, kLogScaleMin, kLogScaleMax), std::clamp(log_above, kLogScaleMin, kLogScaleMax)});
  return laplace_sides(b.first, b.second);
}

double LawLikelihood::square_of_normal_ratio(const Eigen::VectorXd& theta) const {
  if (scatter_.kind != ScatterKind::normal_laplace) return 0.0;
  return exp(2.0 * std::clamp(theta[theta.size() - 1], kLogScaleMin, -kLogScaleMin));
}

LawLikelihood::Scales LawLikelihood::with_normal_part(const LaplaceSides& sides, double square_of_ratio,
                                                      std::size_t k) const {
  if (!(square_of_ratio > 0.0)) return {sides, data_.tau[k], inverse_tau_[k], 0.0};
  const double normal = square_of_ratio * sides.b_below * sides.b_above;
  const double all = normal + square(data_.tau[k]);
  const double tau = std::sqrt(all);
  return {sides, tau, 1.0 / tau, normal / all};
}

LawLikelihood::Scales LawLikelihood::scales(const Eigen::VectorXd& theta, std::size_t k) const {
  return with_normal_part(sides(theta, k), square_of_normal_ratio(theta), k);
}

NormalLaplace LawLikelihood::density_at(double d, const Scales& s) const {
  if (scatter_.kind == ScatterKind::normal) return normal_density(d, s.sides.b_below, s.tau);
  NormalLaplace f = normal_laplace(d, s.sides, s.tau, s.inverse_tau);
  f.d_log_tau *= s.normal_share;  // by rho from here on
  if (scatter_.kind == ScatterKind::normal_laplace) {
    f.d_log_below += 0.5 * f.d_log_tau;
    f.d_log_above += 0.5 * f.d_log_tau;
    const double odds_of_lost = kLostDensity * exp(-f.log_density);
    const double not_lost = 1.0 / (1.0 + odds_of_lost);
    f.log_density += log1p(odds_of_lost);
    f.d_location *= not_lost;
    f.d_log_below *= not_lost;
    f.d_log_above *= not_lost;
    f.d_log_tau *= not_lost;
  }
  return f;
}

void LawLikelihood::add_score(const NormalLaplace& f, std::size_t k, const double* law_row, double* gradient) const {
  for (Eigen::Index i = 0; i < n_law_; ++i) gradient[i] += f.d_location * law_row[i];
  double* of_scales = gradient + n_law_;
  if (!scatter_.is_two_sided()) return add_powers(f.d_log_below + f.d_log_above, x_[k], scatter_.n_terms, of_scales);
  add_powers(f.d_log_below, x_[k], scatter_.n_terms, of_scales);
  add_powers(f.d_log_above, x_[k], scatter_.n_terms, of_scales + scatter_.n_terms);
  if (scatter_.kind == ScatterKind::normal_laplace) of_scales[2 * scatter_.n_terms] += f.d_log_tau;
}

double LawLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!theta.allFinite()) return -HUGE_VAL;
  const std::optional<LaplaceSides> one = scatter_.n_terms == 1 ? std::optional(sides(theta, 0)) : std::nullopt;
  const double square_of_ratio = square_of_normal_ratio(theta);
  // blocks of fixed size, added in order: the same sum for any number of threads
  const std::size_t n_blocks = (data_.size() + kBlock - 1) / kBlock;
  std::vector<double> sums(n_blocks, 0.0);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(gradient ? n_parameters() : 0, static_cast<Eigen::Index>(n_blocks));
  parallel_for(n_blocks, 0, [&](std::size_t block) {
    double* of_block = gradient ? gradients.col(static_cast<Eigen::Index>(block)).data() : nullptr;
    for (std::size_t k = block * kBlock; k < std::min(data_.size(), (block + 1) * kBlock); ++k) {
      std::array<double, kMostLawParameters> row;
      const double residual = data_.eps[k] - eps_of(theta, k, of_block ? row.data() : nullptr);
      const NormalLaplace f = density_at(residual, with_normal_part(one ? *one : sides(theta, k), square_of_ratio, k));
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
  return sum - penalty(theta, gradient);
}

double LawLikelihood::penalty(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!scatter_.is_two_sided()) return 0.0;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  double sum = 0.0;
  if (scatter_.kind == ScatterKind::normal_laplace) {
    const double rho = theta[theta.size() - 1];
    sum += 0.5 * kPrecisionOfRatio * rho * rho;
    if (gradient) (*gradient)[theta.size() - 1] -= kPrecisionOfRatio * rho;
  }
  for (Eigen::Index k = n_law_; k < n_law_ + n_terms; ++k) {
    const double d = theta[k + n_terms] - theta[k];
    sum += 0.5 * kPrecisionOfAsymmetry * d * d;
    if (!gradient) continue;
    (*gradient)[k] += kPrecisionOfAsymmetry * d;
    (*gradient)[k + n_terms] -= kPrecisionOfAsymmetry * d;
  }
  return sum;
}

void LawLikelihood::add_penalty_curvature(const Eigen::VectorXd& theta, Eigen::MatrixXd& information) const {
  if (!scatter_.is_two_sided()) return;
  if (scatter_.kind == ScatterKind::normal_laplace)
    information(theta.size() - 1, theta.size() - 1) += kPrecisionOfRatio;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  for (Eigen::Index k = n_law_; k < n_law_ + n_terms; ++k) {
    constexpr double curvature = kPrecisionOfAsymmetry;
    information(k, k) += curvature;
    information(k + n_terms, k + n_terms) += curvature;
    information(k, k + n_terms) -= curvature;
    information(k + n_terms, k) -= curvature;
  }
}

NormalLaplace LawLikelihood::density(const Eigen::VectorXd& theta, std::size_t k) const {
  return density_at(data_.eps[k] - eps_of(theta, k, nullptr), scales(theta, k));
}

double LawLikelihood::probability_below(const Eigen::VectorXd& theta, std::size_t k) const {
  const Scales s = scales(theta, k);
  const double d = data_.eps[k] - eps_of(theta, k, nullptr);
  if (scatter_.kind == ScatterKind::normal)
    return 0.5 * erfc(-d / std::sqrt(2.0 * (square(s.sides.b_below) + square(s.tau))));
  return normal_laplace_cdf(d, s.sides.b_below, s.sides.b_above, s.tau);
}

double LawLikelihood::probability_of_lost(const Eigen::VectorXd& theta, std::size_t k) const {
  if (scatter_.kind != ScatterKind::normal_laplace) return 0.0;
  // the density with lost ones is f (1 + odds)
  return std::min(1.0, kLostDensity * exp(-density(theta, k).log_density));
}

Eigen::Matrix4d LawLikelihood::information_of(const Eigen::VectorXd& theta, std::size_t k) const {
  const Scales s = scales(theta, k);
  if (scatter_.kind != ScatterKind::normal) {
    // d log tau = share d rho + share / 2 (d log b_below + d log b_above)
    Eigen::Matrix4d by_parameters = Eigen::Matrix4d::Identity();
    const double of_scales = scatter_.kind == ScatterKind::normal_laplace ? 0.5 * s.normal_share : 0.0;
    by_parameters.row(3) << 0.0, of_scales, of_scales, s.normal_share;
    return by_parameters.transpose() * normal_laplace_information(s.sides.b_below, s.sides.b_above, s.tau) *
           by_parameters;
  }
  const double variance = square(s.sides.b_below) + square(s.tau), share = square(s.sides.b_below) / variance;
  return Eigen::Vector4d(1.0 / variance, 2.0 * share * share, 0.0, 0.0).asDiagonal();
}

Eigen::MatrixXd LawLikelihood::design(const Eigen::VectorXd& theta, std::size_t k) const {
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  // predictors (rows): location, log b_below, log b_above, rho
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(4, n_parameters());
  std::array<double, kMostLawParameters> row;
  eps_of(theta, k, row.data());
  for (Eigen::Index i = 0; i < n_law_; ++i) design(0, i) = row[static_cast<std::size_t>(i)];
  const Eigen::Index of_above = n_law_ + (scatter_.is_two_sided() ? n_terms : 0);
  for (Eigen::Index i = 0; i < n_terms; ++i)
    design(1, n_law_ + i) = design(2, of_above + i) = power(x_[k], static_cast<int>(i));
  if (scatter_.kind == ScatterKind::normal_laplace) design(3, n_parameters() - 1) = 1.0;
  return design;
}

std::size_t LawLikelihood::information_stride() const {
  constexpr std::size_t kEnough = 600;  // a stratified mean over so many speeds is good to a percent
  return std::max<std::size_t>(1, data_.size() / kEnough);
}

Eigen::MatrixXd LawLikelihood::information(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_parameters(), n_parameters());
  std::size_t n = 0;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride, ++n) {
    const Eigen::MatrixXd at = design(theta, k);
    sum.noalias() += at.transpose() * information_of(theta, k) * at;
  }
  sum *= static_cast<double>(data_.size()) / static_cast<double>(n);
  add_penalty_curvature(theta, sum);
  return sum;
}

std::vector<Eigen::MatrixXd> LawLikelihood::information_by_drop(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  std::vector<Eigen::Matrix4d> of_samples;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride) of_samples.push_back(information_of(theta, k));
  const std::vector<std::vector<std::size_t>> samples = samples_by_drop(data_.drop, n_drops());
  std::vector<Eigen::MatrixXd> sums(samples.size(), Eigen::MatrixXd::Zero(n_parameters(), n_parameters()));
  parallel_for(blocks_of_drops(samples.size()), 0, [&](std::size_t block) {
    for (std::size_t d = block * kDrops; d < std::min(samples.size(), (block + 1) * kDrops); ++d) {
      for (const std::size_t k : samples[d]) {
        const Eigen::MatrixXd at = design(theta, k);
        sums[d].noalias() += at.transpose() * of_samples[std::min(k / stride, of_samples.size() - 1)] * at;
      }
    }
  });
  return sums;
}

std::size_t LawLikelihood::n_drops() const {
  return data_.drop.empty() ? 0 : *std::max_element(data_.drop.begin(), data_.drop.end()) + 1;
}

Eigen::MatrixXd LawLikelihood::scores_by_drop(const Eigen::VectorXd& theta) const {
  const std::vector<std::vector<std::size_t>> samples = samples_by_drop(data_.drop, n_drops());
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(samples.size()));
  parallel_for(blocks_of_drops(samples.size()), 0, [&](std::size_t block) {
    std::array<double, kMostLawParameters> row;
    for (std::size_t d = block * kDrops; d < std::min(samples.size(), (block + 1) * kDrops); ++d) {
      double* const of_drop = scores.col(static_cast<Eigen::Index>(d)).data();
      for (const std::size_t k : samples[d]) {
        const double residual = data_.eps[k] - eps_of(theta, k, row.data());
        add_score(density_at(residual, scales(theta, k)), k, row.data(), of_drop);
      }
    }
  });
  return scores;
}

ScatterModel LawLikelihood::scatter_model(const Eigen::VectorXd& theta) const {
  const double* c = theta.data() + n_law_;
  ScatterModel result;
  result.v_ref_mps = scatter_.v_ref_mps;
  result.log_below.assign(c, c + scatter_.n_terms);
  if (scatter_.is_two_sided()) c += scatter_.n_terms;
  result.log_above.assign(c, c + scatter_.n_terms);
  result.normal_ratio = std::sqrt(square_of_normal_ratio(theta));
  return result;
}

}  // namespace bouncelab::fit
