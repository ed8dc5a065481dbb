// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/by_drop.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>
#include <vector>

#include "law/distributions.hpp"

namespace bouncelab::fit {
namespace {

/// Curvature of the log-likelihood in whitened coordinates, sign reversed, by differences of the gradient over one
/// standard error: that far the kinks of single samples are smoothed out. Of very many samples by each sample's own
/// differences: those by parameters take up to 30 passes.
Eigen::MatrixXd curvature(const LawLikelihood& likelihood, const Eigen::VectorXd& theta, const Eigen::MatrixXd& white) {
  if (likelihood.data().size() >= kVeryMany) return white.transpose() * likelihood.observed_information(theta) * white;
  const Eigen::Index n_theta = theta.size();
  Eigen::MatrixXd h(n_theta, n_theta);
  for (Eigen::Index j = 0; j < n_theta; ++j) {
    Eigen::VectorXd ahead, behind;
    const Eigen::VectorXd step = white.col(j);
    likelihood(theta + step, &ahead);
    likelihood(theta - step, &behind);
    h.col(j) = 0.5 * white.transpose() * (behind - ahead);
  }
  return 0.5 * (h + h.transpose());
}

}  // namespace

Eigen::MatrixXd ErrorsByDrop::covariance() const {
  const auto n = static_cast<double>(moves.cols());
  return (n - 1.0) / n * (moves * moves.transpose());
}

double ErrorsByDrop::standard_error(const Eigen::VectorXd& direction) const {
  const auto n = static_cast<double>(moves.cols());
  return std::sqrt((n - 1.0) / n) * (direction.transpose() * moves).norm();
}

ProfileLevels ErrorsByDrop::reach() const {
  const double n_free = static_cast<double>(moves.cols()) - 1.0;
  return {student_t_quantile(0.8413447460685429, n_free), student_t_quantile(0.975, n_free)};
}

ProfileLevels ErrorsByDrop::profile_levels_of(const Eigen::VectorXd& direction, const Eigen::MatrixXd& white) const {
  const double ratio = standard_error(direction) / (white.transpose() * direction).norm();
  const ProfileLevels levels = reach();
  return {ratio * levels.z68, ratio * levels.z95};
}

std::optional<ErrorsByDrop> errors_by_drop(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                           const Eigen::MatrixXd& white) {
  constexpr double kMostOfOneDrop = 0.9;
  if (likelihood.n_drops() < kFewestDrops) return std::nullopt;
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(theta.size(), theta.size());
  Eigen::MatrixXd observed = curvature(likelihood, theta, white);
  const Eigen::LLT<Eigen::MatrixXd> h(observed);
  if (h.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd scores = white.transpose() * likelihood.scores_by_drop(theta);
  const std::vector<Eigen::MatrixXd> information = likelihood.information_by_drop(theta);
  for (Eigen::Index d = 0; d < scores.cols(); ++d) {
    const Eigen::MatrixXd leverage = white.transpose() * information[static_cast<std::size_t>(d)] * white;
    if (Eigen::LLT<Eigen::MatrixXd>(kMostOfOneDrop * unit - leverage).info() != Eigen::Success) return std::nullopt;
    scores.col(d) = Eigen::LLT<Eigen::MatrixXd>(unit - leverage).solve(scores.col(d)).eval();
  }
  return ErrorsByDrop{-(white * h.solve(scores)), std::move(observed)};
}

std::optional<ErrorsByDrop> errors_by_sample(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                             const Eigen::MatrixXd& white) {
  constexpr double kSamplesPerParameter = 30.0;
  const auto n = static_cast<double>(likelihood.data().size()), p = static_cast<double>(theta.size());
  if (n < kSamplesPerParameter * p) return std::nullopt;
  Eigen::MatrixXd observed = curvature(likelihood, theta, white);
  const Eigen::LLT<Eigen::MatrixXd> h(observed);
  if (h.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixXd scores = white.transpose() * likelihood.scores_by_sample(theta);
  // each has p/n of what is known
  return ErrorsByDrop{white * h.solve(scores) * (-n / (n - p)), std::move(observed)};
}

}  // namespace bouncelab::fit
