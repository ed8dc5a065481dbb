// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/result_matrix.hpp"

namespace bouncelab::fit {

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
