// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "bouncelab/fit/estimate.hpp"

// Products and decompositions of matrices. Eigen compiles them anew in each file that asks for them, for some seconds;
// in linalg.cpp they are compiled once.

namespace bouncelab::fit {

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);             ///< A B
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);  ///< A^T B
Eigen::MatrixXd gram(const Eigen::MatrixXd& a);                                          ///< A A^T
Eigen::MatrixXd congruence(const Eigen::MatrixXd& a, const Eigen::MatrixXd& m);          ///< A^T M A

/// M = L L^T of a symmetric, positive definite M.
struct Cholesky {
  Eigen::MatrixXd l;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;
  Eigen::MatrixXd inverse() const;
  double log_determinant() const;  ///< of M
};
/// @return nullopt where M is not positive definite
std::optional<Cholesky> cholesky(const Eigen::MatrixXd& m);

/// Of a square matrix that has one.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& m);

/// The x that makes |M x - right| least, and of several such ones the shortest.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& m, const Eigen::MatrixXd& right);

/// Of a symmetric matrix, rising.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& m);

/// The same of the matrix scaled to a unit diagonal.
Eigen::VectorXd scaled_eigenvalues(const Eigen::MatrixXd& m);

/// Inverse square root L of a positive semidefinite matrix: L L^T = M^-1, with eigenvalues of the scaled matrix below
/// `floor` lifted to it. M is scaled to a unit diagonal first.
Eigen::MatrixXd whitening(const Eigen::MatrixXd& m, double floor);

/// An orthogonal matrix whose first column is along `direction`.
Eigen::MatrixXd rotation_along(const Eigen::VectorXd& direction);

/// Rows as a result has them.
Matrix to_matrix(const Eigen::MatrixXd& m);

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

}  // namespace bouncelab::fit
