// SPDX-License-Identifier: GPL-3.0-or-later
/// Special functions and roots by the GNU Scientific Library (GSL), quadrature, order statistics.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace bouncelab {

/// Of a standard normal distribution: half of the interval that holds 95 % of it, and its standard deviation over the
/// median of its absolute values.
inline constexpr double kNormal95 = 1.959963984540054, kSdOverMad = 1.4826;

/// GSL's own handler of errors ends the program. Whoever calls GSL calls this first, and looks at every return code.
void switch_off_gsl_error_handler();

/// J_n(x). @param n  >= 0. Error 1e-14.
double bessel_j(int n, double x);
/// exp(-|x|) I_n(x). @param n  >= 0. Relative error 1e-14 for n <= 1, 1e-13 for n <= 100.
double scaled_bessel_i(int n, double x);
/// Kaiser's window, I_0(beta sqrt(1 - x^2))/I_0(beta); 0 where |x| > 1.
double kaiser_window(double x, double beta);

struct QuadratureRule {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Gauss-Legendre rule with n >= 1 points on [lo, hi]; exact for polynomials up to degree 2n - 1.
/// @return nodes in ascending order; relative errors of the weights: 1e-15 for n = 4, 1e-13 for n = 100
QuadratureRule gauss_legendre(int n, double lo, double hi);

/// The root of f between lo and hi, to rounding, by Brent's method.
/// @param f  continuous; of different signs at lo and hi, or 0 at one of them
/// @throws InvalidArgument where the signs are the same
double root_between(const std::function<double(double)>& f, double lo, double hi);

/// The value with `rank` values before it in ascending order.
/// @param values  without NaN, in any order; more than `rank` of them
double order_statistic(std::vector<double> values, std::size_t rank);

/// The middle one of the values in ascending order; of an even number the mean of the two in the middle.
/// @param values  without NaN, in any order; at least one
double median(std::vector<double> values);

/// The middle one of the values in ascending order; of an even number the larger of the two in the middle, so that it
/// is always one of the values.
/// @param values  without NaN, in any order; at least one
double upper_median(std::vector<double> values);

}  // namespace bouncelab
