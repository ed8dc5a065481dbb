// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/linalg.hpp"

// What is asked of every sample or drop at the maximum: probabilities, scores, expected information.

namespace bouncelab::fit {

std::vector<double> LawLikelihood::probabilities_of_lost(const Eigen::VectorXd& theta) const {
  const Shape common = shape(theta);
  std::vector<double> p(data_.size());
  visit_all([&](SampleBlock& s) {
    compute(theta, common, s);
    // the density with lost ones is f (1 + odds)
    Block inverse;
    for (std::size_t k = 0; k < s.n; ++k) inverse[k] = -s.f.exponent[k];
    exp_each(std::span(inverse).first(s.n));
    for (std::size_t k = 0; k < s.n; ++k)
      p[s.begin + k] = std::min(1.0, odds_of_lost_density_ * inverse[k] / s.f.factor[k]);
  });
  return p;
}

std::vector<double> LawLikelihood::probabilities_below(const Eigen::VectorXd& theta) const {
  const Shape common = shape(theta);
  std::vector<double> u(data_.size());
  visit_all([&](SampleBlock& s) {
    const NormalPart part = compute_scatter(theta, common, s);
    double* const to = &u[s.begin];
    if (scatter_.kind != ScatterKind::normal)
      return normal_laplace_cdf(s.n, s.residual.data(), s.sides, part.tau, part.inverse_tau, to);
    for (std::size_t k = 0; k < s.n; ++k) to[k] = s.residual[k] / hypot(s.sides.b_below[k], part.tau[k]);
    normal_cdf_each({to, s.n});
  });
  return u;
}

LawLikelihood::Derivatives LawLikelihood::derivatives(const Eigen::VectorXd& theta) const {
  const Shape common = shape(theta);
  Derivatives d;
  for (std::vector<double>* column : {&d.residual, &d.by_location, &d.by_log_below, &d.by_log_above, &d.by_rho})
    column->assign(data_.size(), 0.0);
  if (!model_.is_linear()) d.slope.resize(data_.size());
  visit_all([&](SampleBlock& s) {
    const auto put = [&](const Block& block, std::vector<double>& column) {
      std::copy_n(block.begin(), s.n, column.begin() + static_cast<std::ptrdiff_t>(s.begin));
    };
    compute_curve(theta, s);
    put(s.residual, d.residual);
    compute(theta, common, s);
    put(s.f.d_location, d.by_location);
    put(s.f.d_log_below, d.by_log_below);
    put(s.f.d_log_above, d.by_log_above);
    if (scatter_.kind == ScatterKind::normal_laplace) put(s.f.d_log_tau, d.by_rho);
    if (!model_.is_linear()) put(s.slope[0], d.slope);
  });
  return d;
}

void LawLikelihood::add_score(const Derivatives& d, std::size_t k, double* gradient) const {
  const auto add_powers = [&](double value, double* sums) {
    for (std::size_t j = 0; j < scatter_.n_terms; ++j, value *= x_[k]) sums[j] += value;
  };
  const auto row = static_cast<Eigen::Index>(k);
  for (Eigen::Index i = 0; i < n_law_; ++i)
    gradient[i] += d.by_location[k] * (d.slope.empty() ? basis_(row, i) : d.slope[k]);
  double* of_scales = gradient + n_law_;
  if (!scatter_.is_two_sided()) return add_powers(d.by_log_below[k] + d.by_log_above[k], of_scales);
  add_powers(d.by_log_below[k], of_scales);
  add_powers(d.by_log_above[k], of_scales + scatter_.n_terms);
  if (scatter_.kind == ScatterKind::normal_laplace) of_scales[2 * scatter_.n_terms] += d.by_rho[k];
}

Eigen::MatrixXd LawLikelihood::scores_by_drop(const Eigen::VectorXd& theta) const {
  const Derivatives d = derivatives(theta);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(n_drops()));
  for (std::size_t k = 0; k < data_.size(); ++k)
    add_score(d, k, scores.col(static_cast<Eigen::Index>(data_.drop[k])).data());
  return scores;
}

Eigen::MatrixXd LawLikelihood::scores_by_sample(const Eigen::VectorXd& theta) const {
  const Derivatives d = derivatives(theta);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(data_.size()));
  for (std::size_t k = 0; k < data_.size(); ++k) add_score(d, k, scores.col(static_cast<Eigen::Index>(k)).data());
  return scores;
}

namespace {

constexpr std::size_t kDrops = 16;  // in a block of parallel work
std::size_t blocks_of_drops(std::size_t n_drops) { return (n_drops + kDrops - 1) / kDrops; }

std::vector<std::vector<std::size_t>> samples_by_drop(const std::vector<std::size_t>& drop, std::size_t n_drops) {
  std::vector<std::vector<std::size_t>> samples(n_drops);
  for (std::size_t k = 0; k < drop.size(); ++k) samples[drop[k]].push_back(k);
  return samples;
}

/// sum_ij += e_ij c_i c_j
void add_weighted_square(const Eigen::MatrixXd& e, const Eigen::VectorXd& c, Eigen::MatrixXd& sum) {
  for (Eigen::Index j = 0; j < c.size(); ++j) {
    const double* const of_e = e.col(j).data();
    double* const to = sum.col(j).data();
    for (Eigen::Index i = 0; i < c.size(); ++i) to[i] += of_e[i] * (c[i] * c[j]);
  }
}

}  // namespace

Eigen::Matrix4d LawLikelihood::information_of(const Eigen::VectorXd& theta, std::size_t k) const {
  const Scales s = scales(theta, k);
  if (scatter_.kind == ScatterKind::normal) {
    const double variance = square(s.b_below) + square(s.tau), share = square(s.b_below) / variance;
    return Eigen::Vector4d(1.0 / variance, 2.0 * share * share, 0.0, 0.0).asDiagonal();
  }
  // of the point where the exponentials join and log tau, by the parameters
  Eigen::Matrix4d by_parameters = Eigen::Matrix4d::Identity();
  if (scatter_.kind == ScatterKind::normal_laplace) {
    const ModeOffset& peak = s.peak;
    by_parameters.row(0) << 1.0, -s.size * (0.5 * peak.value - peak.d_asymmetry),
        -s.size * (0.5 * peak.value + peak.d_asymmetry), -s.size * peak.d_rho;
    by_parameters.row(3) << 0.0, 0.5 * s.normal_share, 0.5 * s.normal_share, s.normal_share;
  } else {
    by_parameters.row(3).setZero();
  }
  return by_parameters.transpose() * normal_laplace_information(s.b_below, s.b_above, s.tau) * by_parameters;
}

Eigen::MatrixXd LawLikelihood::expanded(const Eigen::Matrix4d& information) const {
  // to which of location, log b_below, log b_above, rho a parameter belongs; of equal sides, to both
  const Eigen::Index n_terms = static_cast<Eigen::Index>(scatter_.n_terms), n = n_parameters();
  Eigen::MatrixXd belongs = Eigen::MatrixXd::Zero(4, n);
  belongs.row(0).head(n_law_).setOnes();
  belongs.row(1).segment(n_law_, n_terms).setOnes();
  belongs.row(2).segment(n_law_ + (scatter_.is_two_sided() ? n_terms : 0), n_terms).setOnes();
  if (scatter_.kind == ScatterKind::normal_laplace) belongs(3, n - 1) = 1.0;
  return congruence(belongs, information);
}

void LawLikelihood::fill_design(const Eigen::VectorXd& theta, std::size_t k, double* c) const {
  eps_of(theta, k, c);
  double* of_scales = c + n_law_;
  const std::size_t n_sides = scatter_.is_two_sided() ? 2 : 1;
  double power_of_x = 1.0;
  for (std::size_t j = 0; j < scatter_.n_terms; ++j, power_of_x *= x_[k])
    for (std::size_t side = 0; side < n_sides; ++side) of_scales[side * scatter_.n_terms + j] = power_of_x;
  if (scatter_.kind == ScatterKind::normal_laplace) of_scales[n_sides * scatter_.n_terms] = 1.0;
}

std::size_t LawLikelihood::information_stride() const {
  constexpr std::size_t kEnough = 600;  // a stratified mean over so many speeds is good to a percent
  return std::max<std::size_t>(1, data_.size() / kEnough);
}

Eigen::MatrixXd LawLikelihood::information(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_parameters(), n_parameters());
  std::size_t n = 0;
  Eigen::VectorXd c(n_parameters());
  for (std::size_t k = stride / 2; k < data_.size(); k += stride, ++n) {
    fill_design(theta, k, c.data());
    add_weighted_square(expanded(information_of(theta, k)), c, sum);
  }
  sum *= static_cast<double>(data_.size()) / static_cast<double>(n);
  add_penalty_curvature(theta, sum);
  return sum;
}

std::vector<Eigen::MatrixXd> LawLikelihood::information_by_drop(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  std::vector<Eigen::MatrixXd> of_samples;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride)
    of_samples.push_back(expanded(information_of(theta, k)));
  const std::vector<std::vector<std::size_t>> samples = samples_by_drop(data_.drop, n_drops());
  // of n samples in M drops, n / M each: 1e4 of them all tell each drop's share, 1 / M, to 1e-4 of the whole
  constexpr std::size_t kEnough = 10000;
  const std::size_t of_drop = std::max<std::size_t>(1, data_.size() / kEnough);
  std::vector<Eigen::MatrixXd> sums(samples.size(), Eigen::MatrixXd::Zero(n_parameters(), n_parameters()));
  parallel_for(blocks_of_drops(samples.size()), 0, [&](std::size_t block) {
    Eigen::VectorXd c(n_parameters());
    for (std::size_t d = block * kDrops; d < std::min(samples.size(), (block + 1) * kDrops); ++d) {
      const std::size_t n = samples[d].size();
      double n_taken = 0.0;
      for (std::size_t i = std::min(of_drop / 2, n - 1); i < n; i += of_drop, n_taken += 1.0) {
        const std::size_t k = samples[d][i];
        fill_design(theta, k, c.data());
        add_weighted_square(of_samples[std::min(k / stride, of_samples.size() - 1)], c, sums[d]);
      }
      if (of_drop > 1) sums[d] *= static_cast<double>(n) / n_taken;
    }
  });
  return sums;
}

std::size_t LawLikelihood::n_drops() const {
  return data_.drop.empty() ? 0 : *std::max_element(data_.drop.begin(), data_.drop.end()) + 1;
}

}  // namespace bouncelab::fit
