// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/numerics.hpp"

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
    compute_scatter(theta, common, s);
    normal_laplace_cdf(s.n, s.residual.data(), s.sides, s.tau.data(), s.inverse_tau.data(), &u[s.begin]);
  });
  return u;
}

LawLikelihood::LocationScores LawLikelihood::location_scores(const Eigen::VectorXd& theta) const {
  const Shape common = shape(theta);
  LocationScores of{std::vector<double>(data_.size()), std::vector<double>(data_.size())};
  visit_all([&](SampleBlock& s) {
    compute_curve(theta, s);
    std::copy_n(s.residual.begin(), s.n, &of.residual[s.begin]);
    compute(theta, common, s);
    std::copy_n(s.f.d_location.begin(), s.n, &of.score[s.begin]);
  });
  return of;
}

Eigen::MatrixXd LawLikelihood::scores_by_sample(const Eigen::VectorXd& theta) const {
  const Shape common = shape(theta);
  Eigen::MatrixXd scores(n_parameters(), static_cast<Eigen::Index>(data_.size()));
  visit_all([&](SampleBlock& s) {
    compute(theta, common, s);
    for (std::size_t k = 0; k < s.n; ++k)
      scores.col(static_cast<Eigen::Index>(s.begin + k)) =
          design(theta, s.begin + k).transpose() *
          Eigen::Vector4d(s.f.d_location[k], s.f.d_log_below[k], s.f.d_log_above[k], s.f.d_log_tau[k]);
  });
  return scores;
}

Eigen::MatrixXd LawLikelihood::scores_by_drop(const Eigen::VectorXd& theta) const {
  const Eigen::MatrixXd of_samples = scores_by_sample(theta);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(n_drops()));
  for (std::size_t k = 0; k < data_.size(); ++k)
    scores.col(static_cast<Eigen::Index>(data_.drop[k])) += of_samples.col(static_cast<Eigen::Index>(k));
  return scores;
}

Eigen::Matrix4d LawLikelihood::information_of(const Eigen::VectorXd& theta, const Shape& shape, std::size_t k) const {
  SampleBlock s;
  s.begin = k;
  s.n = 1;
  compute_scatter(theta, shape, s);
  // of the point where the exponentials join and log tau, by the parameters
  Eigen::Matrix4d by_parameters = Eigen::Matrix4d::Identity();
  const double size = s.size[0], half = 0.5 * s.peak[0], share = s.normal_share[0];
  by_parameters.row(0) << 1.0, -size * (half - s.peak_by_asymmetry[0]), -size * (half + s.peak_by_asymmetry[0]),
      -size * s.peak_by_rho[0];
  by_parameters.row(3) << 0.0, 0.5 * share, 0.5 * share, share;
  return by_parameters.transpose() * normal_laplace_information(s.sides.b_below[0], s.sides.b_above[0], s.tau[0]) *
         by_parameters;
}

LawLikelihood::Design LawLikelihood::design(const Eigen::VectorXd& theta, std::size_t k) const {
  Design c = Design::Zero(4, n_parameters());
  const auto row = basis_.row(static_cast<Eigen::Index>(k));
  if (model_.is_linear())
    c.row(0).head(n_law_) = row;
  else
    c(0, 0) = viscoelastic_and_slope(exp(0.5 * theta[0]) * row[0]).second;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  double power_of_x = 1.0;
  for (Eigen::Index j = 0; j < n_terms; ++j, power_of_x *= x_[k])
    c(1, n_law_ + j) = c(2, n_law_ + n_terms + j) = power_of_x;
  if (scatter_.has_normal_part) c(3, n_parameters() - 1) = 1.0;
  return c;
}

std::size_t LawLikelihood::information_stride() const {
  constexpr std::size_t kEnough = 600;  // a stratified mean over so many speeds is good to a percent
  return std::max<std::size_t>(1, data_.size() / kEnough);
}

Eigen::MatrixXd LawLikelihood::information(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_parameters(), n_parameters());
  std::size_t n = 0;
  const Shape common = shape(theta);
  for (std::size_t k = stride / 2; k < data_.size(); k += stride, ++n)
    sum += congruence(design(theta, k), information_of(theta, common, k));
  sum *= static_cast<double>(data_.size()) / static_cast<double>(n);
  add_penalty_curvature(theta, sum);
  return sum;
}

std::vector<Eigen::MatrixXd> LawLikelihood::information_by_drop(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  const Shape common = shape(theta);
  std::vector<Eigen::Matrix4d> of_samples;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride)
    of_samples.push_back(information_of(theta, common, k));
  std::vector<Eigen::MatrixXd> sums(n_drops(), Eigen::MatrixXd::Zero(n_parameters(), n_parameters()));
  for (std::size_t k = 0; k < data_.size(); ++k)
    sums[data_.drop[k]] += congruence(design(theta, k), of_samples[std::min(k / stride, of_samples.size() - 1)]);
  return sums;
}

std::size_t LawLikelihood::n_drops() const {
  return data_.drop.empty() ? 0 : *std::max_element(data_.drop.begin(), data_.drop.end()) + 1;
}

}  // namespace bouncelab::fit
