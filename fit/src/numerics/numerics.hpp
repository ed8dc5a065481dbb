// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <functional>
#include <optional>

#include "bouncelab/fit/estimate.hpp"

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

// By GSL, which no other file of fit calls: its error handler, which would end the program, is switched off there.

/// Probability of a chi-square above chi2. @param chi2  >= 0  @param ndf  > 0
double chi2_survival(double chi2, double ndf);

/// Probability of Student's t below t, for nu > 0 degrees of freedom.
double student_t_below(double t, double nu);

/// Probability of Fisher's F above f, for d1 and d2 > 0 degrees of freedom. @param f  >= 0, may be infinite
double f_survival(double f, double d1, double d2);

/// The t below which it falls with probability p. @param p  in [0.5, 1)
double student_t_quantile(double p, double nu);

/// Log-likelihood at x; its gradient where asked for. Not finite: outside the domain.
using LogLikelihood = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd* gradient)>;

struct Maximum {
  Eigen::VectorXd x;
  double loglik = 0.0;
  /// What a quadratic model says is still to be gained, g^T I^-1 g / 2: below 1e-4 the estimate is within a hundredth
  /// of its standard error.
  double gain_left = 0.0;
  bool converged = false;
};

/// Maximises by Ceres' BFGS with a Wolfe line search, in coordinates whitened by the information matrix at the start:
/// there the surface is nearly a unit bowl, whatever the units and correlations of x.
/// @param information  at the start; directions it says nothing about are searched with a bounded step
/// @param tolerance    on the whitened gradient: distance to the maximum in standard errors
Maximum maximise(const LogLikelihood& loglik, const Eigen::VectorXd& start, const Eigen::MatrixXd& information,
                 double tolerance = 2e-3);

}  // namespace bouncelab::fit
