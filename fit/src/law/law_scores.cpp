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
    const NormalPart part = compute_scatter(theta, common, s);
    normal_laplace_cdf(s.n, s.residual.data(), s.sides, part.tau, part.inverse_tau, &u[s.begin]);
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
    for (std::size_t k = 0; k < s.n; ++k) {
      double* to = scores.col(static_cast<Eigen::Index>(s.begin + k)).data();
      for (std::size_t i = 0; i < static_cast<std::size_t>(n_law_); ++i) *to++ = s.f.d_location[k] * slope_of(s, i)[k];
      const auto put_powers = [&](double value) {
        for (std::size_t j = 0; j < scatter_.n_terms; ++j, value *= x_[s.begin + k]) *to++ = value;
      };
      put_powers(s.f.d_log_below[k]);
      put_powers(s.f.d_log_above[k]);
      if (scatter_.has_normal_part()) *to = s.f.d_log_tau[k];
    }
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

Eigen::Matrix4d LawLikelihood::information_of(const Eigen::VectorXd& theta, const Shape& shape, std::size_t k) const {
  SampleBlock s;
  s.begin = k;
  s.n = 1;
  const double tau = *compute_scatter(theta, shape, s).tau;
  // of the point where the exponentials join and log tau, by the parameters
  Eigen::Matrix4d by_parameters = Eigen::Matrix4d::Identity();
  if (scatter_.has_normal_part()) {
    const double size = s.size[0], half = 0.5 * s.peak[0], share = s.normal_share[0];
    by_parameters.row(0) << 1.0, -size * (half - s.peak_by_asymmetry[0]), -size * (half + s.peak_by_asymmetry[0]),
        -size * s.peak_by_rho[0];
    by_parameters.row(3) << 0.0, 0.5 * share, 0.5 * share, share;
  } else {
    by_parameters.row(3).setZero();
  }
  return by_parameters.transpose() * normal_laplace_information(s.sides.b_below[0], s.sides.b_above[0], tau) *
         by_parameters;
}

Eigen::MatrixXd LawLikelihood::expanded(const Eigen::Matrix4d& information) const {
  // to which of location, log b_below, log b_above, rho a parameter belongs
  const Eigen::Index n_terms = static_cast<Eigen::Index>(scatter_.n_terms), n = n_parameters();
  Eigen::MatrixXd belongs = Eigen::MatrixXd::Zero(4, n);
  belongs.row(0).head(n_law_).setOnes();
  belongs.row(1).segment(n_law_, n_terms).setOnes();
  belongs.row(2).segment(n_law_ + n_terms, n_terms).setOnes();
  if (scatter_.has_normal_part()) belongs(3, n - 1) = 1.0;
  return congruence(belongs, information);
}

void LawLikelihood::fill_design(const Eigen::VectorXd& theta, std::size_t k, double* c) const {
  eps_of(theta, k, c);
  double* of_scales = c + n_law_;
  double power_of_x = 1.0;
  for (std::size_t j = 0; j < scatter_.n_terms; ++j, power_of_x *= x_[k])
    of_scales[j] = of_scales[scatter_.n_terms + j] = power_of_x;
  if (scatter_.has_normal_part()) of_scales[2 * scatter_.n_terms] = 1.0;
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
  Eigen::VectorXd c(n_parameters());
  for (std::size_t k = stride / 2; k < data_.size(); k += stride, ++n) {
    fill_design(theta, k, c.data());
    add_weighted_square(expanded(information_of(theta, common, k)), c, sum);
  }
  sum *= static_cast<double>(data_.size()) / static_cast<double>(n);
  add_penalty_curvature(theta, sum);
  return sum;
}

std::vector<Eigen::MatrixXd> LawLikelihood::information_by_drop(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  const Shape common = shape(theta);
  std::vector<Eigen::MatrixXd> of_samples;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride)
    of_samples.push_back(expanded(information_of(theta, common, k)));
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
