// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/maximise.hpp"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#ifndef __EMSCRIPTEN__
#include <glog/logging.h>
#endif

#include <algorithm>
#include <cmath>
#include <mutex>

#include "numerics/linalg.hpp"

namespace bouncelab::fit {
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
               double loglik_at_start, Evaluated& last, Evaluated& best, int& n_evaluations)
      : loglik_(loglik),
        start_(start),
        whitening_(whitening),
        at_start_(loglik_at_start),
        last_(last),
        best_(best),
        n_(n_evaluations) {}

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::Map<const Eigen::VectorXd> y(parameters, start_.size());
    if (last_.y != y) {
      Eigen::VectorXd by_x;
      ++n_;
      const double value = loglik_(start_ + product(whitening_, y), &by_x);
      if (!std::isfinite(value) || !by_x.allFinite()) return false;
      last_ = {y, transposed_product(whitening_, by_x), value};
      if (value > best_.loglik) best_ = last_;
    }
    *cost = at_start_ - last_.loglik;
    if (gradient) Eigen::Map<Eigen::VectorXd>(gradient, start_.size()) = -last_.gradient_by_y;
    return true;
  }
  int NumParameters() const override { return static_cast<int>(start_.size()); }

 private:
  const LogLikelihood& loglik_;
  const Eigen::VectorXd& start_;
  const Eigen::MatrixXd& whitening_;
  double at_start_;
  Evaluated &last_, &best_;
  int& n_;
};

/// Ceres comments on degenerate line searches on standard error; what the search came to is in its result. Searches run
/// side by side: the first silences, the last restores.
#ifdef __EMSCRIPTEN__  // its log is compiled without comments (tools/web/build)
struct QuietCeres {
  QuietCeres() {}
};
#else
class QuietCeres {
 public:
  QuietCeres() {
    const std::lock_guard lock(mutex_);
    if (n_searches_++ > 0) return;
    level_ = FLAGS_minloglevel;
    FLAGS_minloglevel = google::GLOG_ERROR;
  }
  ~QuietCeres() {
    const std::lock_guard lock(mutex_);
    if (--n_searches_ == 0) FLAGS_minloglevel = level_;
  }
  QuietCeres(const QuietCeres&) = delete;
  QuietCeres& operator=(const QuietCeres&) = delete;

 private:
  static inline std::mutex mutex_;
  static inline int n_searches_ = 0, level_ = 0;
};
#endif

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
  result.n_evaluations = 1;
  if (!std::isfinite(result.loglik)) return result;
  const Eigen::MatrixXd white = whitening(information, 1e-6);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(start.size());
  Evaluated last{y, transposed_product(white, gradient), result.loglik};
  Evaluated best = last;
  const WhitenedCost cost(loglik, start, white, result.loglik, last, best, result.n_evaluations);
  ceres::GradientProblem problem(new WhitenedCost(cost));
  ceres::GradientProblemSolver::Summary summary;
  const QuietCeres quiet;
  ceres::Solve(solver_options(tolerance), problem, y.data(), &summary);
  // a search that fails, as where steps end in the impossible, gives nothing of what it found
  if (!summary.IsSolutionUsable()) y = best.y;
  result.x = start + product(white, y);
  if (double ignored = 0.0; last.y != y && !cost.Evaluate(y.data(), &ignored, nullptr)) return result;
  result.loglik = last.loglik;
  result.gain_left = 0.5 * last.gradient_by_y.squaredNorm();
  result.converged = summary.IsSolutionUsable() && result.gain_left < 1e-4;
  return result;
}

}  // namespace bouncelab::fit
