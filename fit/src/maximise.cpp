// SPDX-License-Identifier: GPL-3.0-or-later
#include "maximise.hpp"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace bouncelab {
namespace {

/// The negative log-likelihood of y, x = start + whitening y, less its value at the start.
class WhitenedCost final : public ceres::FirstOrderFunction {
 public:
  WhitenedCost(const LogLikelihood& loglik, const Eigen::VectorXd& start, const Eigen::MatrixXd& whitening,
               double loglik_at_start, int& n_evaluations)
      : loglik_(loglik), start_(start), whitening_(whitening), at_start_(loglik_at_start), n_(n_evaluations) {}

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::Map<const Eigen::VectorXd> y(parameters, start_.size());
    Eigen::VectorXd by_x;
    ++n_;
    const double value = loglik_(start_ + whitening_ * y, gradient ? &by_x : nullptr);
    if (!std::isfinite(value)) return false;
    *cost = at_start_ - value;
    if (gradient) Eigen::Map<Eigen::VectorXd>(gradient, start_.size()) = -whitening_.transpose() * by_x;
    return true;
  }
  int NumParameters() const override { return static_cast<int>(start_.size()); }

 private:
  const LogLikelihood& loglik_;
  const Eigen::VectorXd& start_;
  const Eigen::MatrixXd& whitening_;
  double at_start_;
  int& n_;
};

/// Ceres comments on degenerate line searches on standard error; what the search came to is in its result.
class QuietCeres {
 public:
  QuietCeres() : level_(FLAGS_minloglevel) { FLAGS_minloglevel = google::GLOG_ERROR; }
  ~QuietCeres() { FLAGS_minloglevel = level_; }
  QuietCeres(const QuietCeres&) = delete;
  QuietCeres& operator=(const QuietCeres&) = delete;

 private:
  int level_;
};

ceres::GradientProblemSolver::Options solver_options(double tolerance) {
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::BFGS;
  options.line_search_type = ceres::WOLFE;
  options.max_num_iterations = 200;
  options.function_tolerance = 0.0;  // the cost's size says nothing; the whitened gradient does
  options.gradient_tolerance = tolerance;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

Eigen::MatrixXd whitening(const Eigen::MatrixXd& m, double floor) {
  Eigen::VectorXd scale = m.diagonal();
  for (double& s : scale) s = s > 0.0 ? 1.0 / std::sqrt(s) : 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * m * scale.asDiagonal());
  const Eigen::VectorXd roots = eigen.eigenvalues().cwiseMax(floor).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * eigen.eigenvectors() * roots.asDiagonal();
}

Maximum maximise(const LogLikelihood& loglik, const Eigen::VectorXd& start, const Eigen::MatrixXd& information,
                 double tolerance) {
  Maximum result;
  result.x = start;
  result.loglik = loglik(start, nullptr);
  result.n_evaluations = 1;
  if (!std::isfinite(result.loglik)) return result;
  const Eigen::MatrixXd white = whitening(information, 1e-6);
  const double at_start = result.loglik;
  Eigen::VectorXd y = Eigen::VectorXd::Zero(start.size());
  ceres::GradientProblem problem(new WhitenedCost(loglik, start, white, at_start, result.n_evaluations));
  ceres::GradientProblemSolver::Summary summary;
  const QuietCeres quiet;
  ceres::Solve(solver_options(tolerance), problem, y.data(), &summary);
  result.x = start + white * y;
  Eigen::VectorXd gradient;
  result.loglik = loglik(result.x, &gradient);
  result.gain_left = 0.5 * (white.transpose() * gradient).squaredNorm();
  result.converged = summary.IsSolutionUsable() && result.gain_left < 1e-4;
  return result;
}

}  // namespace bouncelab
