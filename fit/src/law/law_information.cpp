// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/law_likelihood.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kDrops = 16;  // in a block of parallel work
std::size_t blocks_of_drops(std::size_t n_drops) { return (n_drops + kDrops - 1) / kDrops; }

std::vector<std::vector<std::size_t>> samples_by_drop(const std::vector<std::size_t>& drop, std::size_t n_drops) {
  std::vector<std::vector<std::size_t>> samples(n_drops);
  for (std::size_t k = 0; k < drop.size(); ++k) samples[drop[k]].push_back(k);
  return samples;
}

}  // namespace

Eigen::Matrix4d LawLikelihood::information_of(const Eigen::VectorXd& theta, std::size_t k) const {
  const Scales s = scales(theta, k);
  if (scatter_.kind == ScatterKind::normal) {
    const double variance = square(s.sides.b_below) + square(s.tau), share = square(s.sides.b_below) / variance;
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
  return by_parameters.transpose() * normal_laplace_information(s.sides.b_below, s.sides.b_above, s.tau) *
         by_parameters;
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
  return scores_of(theta, samples_by_drop(data_.drop, n_drops()));
}

Eigen::MatrixXd LawLikelihood::scores_by_sample(const Eigen::VectorXd& theta) const {
  std::vector<std::vector<std::size_t>> samples;
  for (std::size_t k = 0; k < data_.size(); ++k) samples.push_back({k});
  return scores_of(theta, samples);
}

Eigen::MatrixXd LawLikelihood::scores_of(const Eigen::VectorXd& theta,
                                         const std::vector<std::vector<std::size_t>>& groups) const {
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(groups.size()));
  const Shape common = shape(theta);
  parallel_for(blocks_of_drops(groups.size()), 0, [&](std::size_t block) {
    std::array<double, kMostLawParameters> row;
    for (std::size_t d = block * kDrops; d < std::min(groups.size(), (block + 1) * kDrops); ++d) {
      double* const of_group = scores.col(static_cast<Eigen::Index>(d)).data();
      for (const std::size_t k : groups[d]) {
        const double residual = data_.eps[k] - eps_of(theta, k, row.data());
        add_score(density_at(residual, scales(theta, common, k)), k, row.data(), of_group);
      }
    }
  });
  return scores;
}

}  // namespace bouncelab::fit
