// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/by_drop.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "law/distributions.hpp"

namespace bouncelab::fit {
namespace {

/// Observed information of each drop in whitened coordinates: element (i, j) of drop d at row i + j n_theta, column d.
Eigen::MatrixXd information_by_drop(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                    const Eigen::MatrixXd& white) {
  const Eigen::Index n_theta = theta.size();
  Eigen::MatrixXd information;
  for (Eigen::Index j = 0; j < n_theta; ++j) {
    const Eigen::VectorXd step = white.col(j);
    const Eigen::MatrixXd fall = likelihood.scores_by_drop(theta - step) - likelihood.scores_by_drop(theta + step);
    if (j == 0) information.resize(n_theta * n_theta, fall.cols());
    information.middleRows(j * n_theta, n_theta) = 0.5 * white.transpose() * fall;
  }
  return information;
}

Eigen::MatrixXd symmetric(const Eigen::VectorXd& elements, Eigen::Index n) {
  const Eigen::Map<const Eigen::MatrixXd> m(elements.data(), n, n);
  return 0.5 * (m + m.transpose());
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
  const Eigen::Index n_theta = theta.size();
  const Eigen::MatrixXd scores = white.transpose() * likelihood.scores_by_drop(theta);
  const Eigen::MatrixXd by_drop = information_by_drop(likelihood, theta, white);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n_theta, n_theta);
  likelihood.add_penalty_curvature(theta, all);
  all = (white.transpose() * all * white + symmetric(by_drop.rowwise().sum(), n_theta)).eval();
  ErrorsByDrop errors{Eigen::MatrixXd(n_theta, scores.cols())};
  for (Eigen::Index d = 0; d < scores.cols(); ++d) {
    const Eigen::MatrixXd of_drop = symmetric(by_drop.col(d), n_theta);
    if (Eigen::LLT<Eigen::MatrixXd>(kMostOfOneDrop * all - of_drop).info() != Eigen::Success) return std::nullopt;
    errors.moves.col(d) = -(white * Eigen::LLT<Eigen::MatrixXd>(all - of_drop).solve(scores.col(d)));
  }
  return errors;
}

}  // namespace bouncelab::fit
