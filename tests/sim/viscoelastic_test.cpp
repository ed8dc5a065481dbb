// SPDX-License-Identifier: GPL-3.0-or-later
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit.h>
#include <gsl/gsl_odeiv2.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"

namespace bouncelab::sim {
namespace {

/// Viscoelastic spheres: x'' = -(x^(3/2) + b sqrt(x) x'), scaled so that x'(0) = 1; b = gamma v^(1/5).
int contact(double, const double y[], double dydt[], void* parameter) {
  const double b = *static_cast<const double*>(parameter);
  const double root = std::sqrt(std::max(0.0, y[0]));
  dydt[0] = y[1];
  dydt[1] = -root * (y[0] + b * y[1]);
  return GSL_SUCCESS;
}

/// -x' at the end of contact, which is when the force vanishes, x + b x' = 0, not when x does: no attraction.
double restitution_by_integration(double b) {
  gsl_odeiv2_system system{contact, nullptr, 2, &b};
  gsl_odeiv2_step* step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, 2);
  gsl_odeiv2_control* control = gsl_odeiv2_control_y_new(1e-16, 1e-15);
  gsl_odeiv2_evolve* evolve = gsl_odeiv2_evolve_alloc(2);
  // over the first instant sqrt(x) is not smooth: x = t - 4 b t^(5/2) / 15, x' = 1 - 2 b t^(3/2) / 3 to O(t^(7/2))
  const double t0 = 1e-6;
  double t = t0, h = 1e-6;
  double y[2] = {t0 - 4.0 / 15.0 * b * std::pow(t0, 2.5), 1.0 - 2.0 / 3.0 * b * std::pow(t0, 1.5)};
  double y_before[2] = {y[0], y[1]}, t_before = t;
  while (y[0] + b * y[1] > 0.0) {
    y_before[0] = y[0];
    y_before[1] = y[1];
    t_before = t;
    gsl_odeiv2_evolve_apply(evolve, control, step, &system, &t, 10.0, &h, y);
  }
  // halve the last step until the force's zero is found
  double lo = 0.0, hi = t - t_before;
  double end[2] = {y[0], y[1]}, error[2];
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (lo + hi);
    end[0] = y_before[0];
    end[1] = y_before[1];
    gsl_odeiv2_step_apply(step, t_before, middle, end, error, nullptr, nullptr, &system);
    (end[0] + b * end[1] > 0.0 ? lo : hi) = middle;
  }
  gsl_odeiv2_evolve_free(evolve);
  gsl_odeiv2_control_free(control);
  gsl_odeiv2_step_free(step);
  return -end[1];
}

/// Least squares for C_first ... C_last in eps - known terms = sum C_i x^i, at Chebyshev points.
std::vector<double> fitted(int first, int last, double x_lo, double x_hi, const std::vector<double>& known) {
  constexpr int kPoints = 60;
  const auto n = static_cast<std::size_t>(last - first + 1);
  gsl_matrix* a = gsl_matrix_alloc(kPoints, n);
  gsl_vector* right = gsl_vector_alloc(kPoints);
  gsl_vector* c = gsl_vector_alloc(n);
  gsl_matrix* covariance = gsl_matrix_alloc(n, n);
  for (std::size_t p = 0; p < kPoints; ++p) {
    const double x = 0.5 * (x_lo + x_hi) +
                     0.5 * (x_hi - x_lo) * std::cos(3.14159265358979 * (static_cast<double>(p) + 0.5) / kPoints);
    double rest = restitution_by_integration(x * x) - 1.0;
    for (std::size_t i = 0; i < known.size(); ++i) rest -= known[i] * std::pow(x, static_cast<double>(i));
    gsl_vector_set(right, p, rest / std::pow(x, first));  // errors of eps are alike: weights x^first keep columns alike
    for (std::size_t k = 0; k < n; ++k) gsl_matrix_set(a, p, k, std::pow(x, static_cast<double>(k)));
  }
  gsl_multifit_linear_workspace* work = gsl_multifit_linear_alloc(kPoints, n);
  double chi2 = 0.0;
  gsl_multifit_linear(a, right, c, covariance, &chi2, work);
  std::vector<double> result;
  for (std::size_t k = 0; k < n; ++k) result.push_back(gsl_vector_get(c, k));
  gsl_multifit_linear_free(work);
  gsl_matrix_free(covariance);
  gsl_vector_free(c);
  gsl_vector_free(right);
  gsl_matrix_free(a);
  return result;
}

TEST(ViscoelasticContact, CoefficientsOfTheSeriesFollowFromTheContactEquationToTheDigitsThatTheDerivationSupports) {
  // the two after C_2 have closed forms: the derivation's own test. Then five digits of C_6, three of C_7, two of C_8,
  // one of C_9, the sign of C_10: what changes with the range and the number of terms, rounded up
  const std::vector<double> closed = fitted(4, 17, 0.12, 0.75, {0.0, 0.0, kViscoelasticC[2], 0.0});
  EXPECT_NEAR(closed[0], kViscoelasticC[4], 1e-6);
  EXPECT_NEAR(closed[1], kViscoelasticC[5], 1e-4);
  const std::vector<double> exact{0.0, 0.0, kViscoelasticC[2], 0.0, kViscoelasticC[4], kViscoelasticC[5]};
  const std::vector<double> c = fitted(6, 17, 0.12, 0.75, exact);
  const double supported[] = {2e-6, 1e-4, 1e-3, 1e-2, 6e-2};
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(c[k], kViscoelasticC[k + 6], supported[k]) << "C_" << k + 6;
}

}  // namespace
}  // namespace bouncelab::sim
