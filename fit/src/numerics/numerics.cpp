// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/numerics.hpp"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>
#include <gsl/gsl_cdf.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

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

namespace {

[[maybe_unused]] const bool kHandlerIsOff = (switch_off_gsl_error_handler(), true);

}  // namespace

double chi2_survival(double chi2, double ndf) { return gsl_cdf_chisq_Q(chi2, ndf); }

double student_t_below(double t, double nu) { return gsl_cdf_tdist_P(t, nu); }

double f_survival(double f, double d1, double d2) { return std::isinf(f) ? 0.0 : gsl_cdf_fdist_Q(f, d1, d2); }

double student_t_quantile(double p, double nu) { return gsl_cdf_tdist_Pinv(p, nu); }

namespace {

/// One evaluation: each costs a pass over all samples, and the solver asks for the same point more than once.
struct Evaluated {
  Eigen::VectorXd y, gradient_by_y;
  double loglik = 0.0;
};

/// The negative log-likelihood of y, x = start + whitening y, less its value at the start.
class WhitenedCost final : public ceres::FirstOrderFunction {
 public:
  WhitenedCost(const LogLikelihood& loglik, const Eigen::VectorXd& start, const Eigen::MatrixXd& whitening,
               const Evaluated& at_start)
      : last(at_start),
        best(at_start),
        loglik_(loglik),
        start_(start),
        whitening_(whitening),
        at_start_(at_start.loglik) {}

  mutable Evaluated last, best;

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::Map<const Eigen::VectorXd> y(parameters, start_.size());
    if (last.y != y) {
      Eigen::VectorXd by_x;
      const double value = loglik_(start_ + product(whitening_, y), &by_x);
      if (!std::isfinite(value) || !by_x.allFinite()) return false;
      last = {y, transposed_product(whitening_, by_x), value};
      if (value > best.loglik) best = last;
    }
    *cost = at_start_ - last.loglik;
    if (gradient) Eigen::Map<Eigen::VectorXd>(gradient, start_.size()) = -last.gradient_by_y;
    return true;
  }
  int NumParameters() const override { return static_cast<int>(start_.size()); }

 private:
  const LogLikelihood& loglik_;
  const Eigen::VectorXd& start_;
  const Eigen::MatrixXd& whitening_;
  double at_start_;
};

/// Ceres comments on degenerate line searches on standard error; what the search came to is in its result.
void silence_ceres() {
#ifndef __EMSCRIPTEN__  // its log is compiled without comments (tools/web/build)
  [[maybe_unused]] static const int level = FLAGS_minloglevel = google::GLOG_ERROR;
#endif
}

ceres::GradientProblemSolver::Options solver_options(double tolerance) {
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::BFGS;
  options.line_search_type = ceres::WOLFE;
  // by halves: polynomials would end elsewhere within the tolerance, and numbers would differ from earlier versions
  options.line_search_interpolation_type = ceres::BISECTION;
  options.max_num_iterations = 200;
  options.function_tolerance = 0.0;  // the cost's size says nothing; the whitened gradient does
  options.gradient_tolerance = tolerance;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

Maximum maximise(const LogLikelihood& loglik, const Eigen::VectorXd& start, const Eigen::MatrixXd& information,
                 double tolerance) {
  Maximum result;
  result.x = start;
  Eigen::VectorXd gradient;
  result.loglik = loglik(start, &gradient);
  if (!std::isfinite(result.loglik)) return result;
  const Eigen::MatrixXd white = whitening(information, 1e-6);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(start.size());
  auto* const cost = new WhitenedCost(loglik, start, white, {y, transposed_product(white, gradient), result.loglik});
  ceres::GradientProblem problem(cost);
  ceres::GradientProblemSolver::Summary summary;
  silence_ceres();
  ceres::Solve(solver_options(tolerance), problem, y.data(), &summary);
  // a search that fails, as where steps end in the impossible, gives nothing of what it found
  if (!summary.IsSolutionUsable()) y = cost->best.y;
  result.x = start + product(white, y);
  if (double ignored = 0.0; !cost->Evaluate(y.data(), &ignored, nullptr)) return result;
  result.loglik = cost->last.loglik;
  result.gain_left = 0.5 * cost->last.gradient_by_y.squaredNorm();
  result.converged = summary.IsSolutionUsable() && result.gain_left < 1e-4;
  return result;
}

}  // namespace bouncelab::fit
