// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/law_likelihood.hpp"

// What is asked of every sample at the maximum, by the blocks that the likelihood itself is made of.

namespace bouncelab::fit {

template <class Compute>
void LawLikelihood::in_blocks(const Compute& compute) const {
  parallel_for((data_.size() + kParallel - 1) / kParallel, 0, [&](std::size_t part) {
    SampleBlock s;
    const std::size_t end = std::min(data_.size(), (part + 1) * kParallel);
    for (s.begin = part * kParallel; s.begin < end; s.begin += s.n) {
      s.n = std::min(kBlockSize, end - s.begin);
      compute(s);
    }
  });
}

std::vector<double> LawLikelihood::probabilities_of_lost(const Eigen::VectorXd& theta) const {
  const Shape common = shape(theta);
  std::vector<double> p(data_.size());
  in_blocks([&](SampleBlock& s) {
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
  in_blocks([&](SampleBlock& s) {
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
  in_blocks([&](SampleBlock& s) {
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

}  // namespace bouncelab::fit
