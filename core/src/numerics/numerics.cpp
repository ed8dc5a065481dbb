// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/numerics.hpp"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_roots.h>
#include <gsl/gsl_sf_bessel.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

void check(int status, const std::string& what) {
  if (status != GSL_SUCCESS) throw InvalidArgument(what + ": " + gsl_strerror(status));
}

using BesselFunction = int (*)(int, double, gsl_sf_result*);

double bessel(BesselFunction function, const char* name, int n, double x) {
  switch_off_gsl_error_handler();
  gsl_sf_result result{};
  const int status = function(n, x, &result);
  if (status != GSL_EUNDRFLW)  // its value is 0 then
    check(status, std::string(name) + " of order " + std::to_string(n) + " at " + std::to_string(x));
  return result.val;
}

}  // namespace

void switch_off_gsl_error_handler() { [[maybe_unused]] static const auto before = gsl_set_error_handler_off(); }

double bessel_j(int n, double x) { return bessel(gsl_sf_bessel_Jn_e, "Bessel's function J", n, x); }

double scaled_bessel_i(int n, double x) { return bessel(gsl_sf_bessel_In_scaled_e, "Bessel's function I", n, x); }

double kaiser_window(double x, double beta) {
  if (std::abs(x) > 1.0) return 0.0;
  const double argument = beta * std::sqrt(1.0 - x * x);
  return scaled_bessel_i(0, argument) / scaled_bessel_i(0, beta) * exp(argument - beta);
}

// Not GSL's rules: the weights of gsl_integration_glfixed are good to 1e-8 beyond the orders that it has as tables,
// those of gsl_integration_fixed to 3e-13 for 100 points, which the low modes of a plate show as 8e-10 of a sound's
// amplitude.
QuadratureRule gauss_legendre(int n, double lo, double hi) {
  QuadratureRule rule;
  for (int k = 0; k < n; ++k) {
    double x = -cos(kPi * (k + 0.75) / (n + 0.5));  // within Newton's reach of the root
    double derivative = 0.0;
    for (int iteration = 0; iteration < 5; ++iteration) {
      double p = 1.0, p_before = 0.0;
      for (int j = 1; j <= n; ++j) {
        const double next = ((2.0 * j - 1.0) * x * p - (j - 1.0) * p_before) / j;
        p_before = p;
        p = next;
      }
      derivative = n * (x * p - p_before) / (x * x - 1.0);
      x -= p / derivative;
    }
    rule.nodes.push_back(0.5 * (lo + hi) + 0.5 * (hi - lo) * x);
    rule.weights.push_back((hi - lo) / ((1.0 - x * x) * derivative * derivative));
  }
  return rule;
}

double root_between(const std::function<double(double)>& f, double lo, double hi) {
  switch_off_gsl_error_handler();
  constexpr int kMaxSteps = 200;  // halving alone takes 60
  std::function<double(double)> copy = f;
  gsl_function function{[](double x, void* g) { return (*static_cast<std::function<double(double)>*>(g))(x); }, &copy};
  const std::unique_ptr<gsl_root_fsolver, void (*)(gsl_root_fsolver*)> solver(
      gsl_root_fsolver_alloc(gsl_root_fsolver_brent), gsl_root_fsolver_free);
  if (!solver) throw std::bad_alloc();
  check(gsl_root_fsolver_set(solver.get(), &function, lo, hi),
        "root: no change of sign between " + std::to_string(lo) + " and " + std::to_string(hi));
  for (int step = 0; step < kMaxSteps; ++step) {
    check(gsl_root_fsolver_iterate(solver.get()), "root");
    const double left = gsl_root_fsolver_x_lower(solver.get()), right = gsl_root_fsolver_x_upper(solver.get());
    if (gsl_root_test_interval(left, right, 0.0, 2.0 * std::numeric_limits<double>::epsilon()) == GSL_SUCCESS) break;
  }
  return gsl_root_fsolver_root(solver.get());
}

double order_statistic(std::vector<double> values, std::size_t rank) {
  assert(rank < values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double upper_median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return order_statistic(std::move(values), middle);
}

}  // namespace bouncelab
