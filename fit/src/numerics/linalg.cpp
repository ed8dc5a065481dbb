// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/linalg.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b; }

Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.transpose() * b; }

Eigen::MatrixXd gram(const Eigen::MatrixXd& a) { return a * a.transpose(); }

Eigen::MatrixXd congruence(const Eigen::MatrixXd& a, const Eigen::MatrixXd& m) {
  return transposed_product(a, product(m, a));
}

std::optional<Cholesky> cholesky(const Eigen::MatrixXd& m) {
  const Eigen::LLT<Eigen::MatrixXd> llt(m);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return Cholesky{llt.matrixL()};
}

Eigen::MatrixXd Cholesky::solve(const Eigen::MatrixXd& right) const {
  const auto lower = l.triangularView<Eigen::Lower>();
  return lower.transpose().solve(lower.solve(right));
}

Eigen::MatrixXd Cholesky::inverse() const { return solve(Eigen::MatrixXd::Identity(l.rows(), l.cols())); }

double Cholesky::log_determinant() const {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < l.rows(); ++i) sum += 2.0 * log(l(i, i));
  return sum;
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& m) {
  return least_squares(m, Eigen::MatrixXd::Identity(m.rows(), m.cols()));
}

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& m, const Eigen::MatrixXd& right) {
  return m.completeOrthogonalDecomposition().solve(right);
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues();
}

Eigen::VectorXd scaled_eigenvalues(const Eigen::MatrixXd& m) {
  const Eigen::VectorXd scale = m.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return eigenvalues(scale.asDiagonal() * m * scale.asDiagonal());
}

Eigen::MatrixXd whitening(const Eigen::MatrixXd& m, double floor) {
  Eigen::VectorXd scale = m.diagonal();
  for (double& s : scale) s = s > 0.0 ? 1.0 / std::sqrt(s) : 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * m * scale.asDiagonal());
  const Eigen::VectorXd roots = eigen.eigenvalues().cwiseMax(floor).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * eigen.eigenvectors() * roots.asDiagonal();
}

/// By Householder's reflection.
Eigen::MatrixXd rotation_along(const Eigen::VectorXd& direction) {
  Eigen::VectorXd v = direction;
  v[0] += std::copysign(direction.norm(), direction[0]);
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(v.size(), v.size());
  return unit - (2.0 / v.squaredNorm()) * v * v.transpose();
}

Matrix to_matrix(const Eigen::MatrixXd& m) {
  Matrix rows(static_cast<std::size_t>(m.rows()));
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) rows[static_cast<std::size_t>(i)].push_back(m(i, j));
  return rows;
}

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd inverse_se = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return inverse_se.asDiagonal() * covariance * inverse_se.asDiagonal();
}

}  // namespace bouncelab::fit
