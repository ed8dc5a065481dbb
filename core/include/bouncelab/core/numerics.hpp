// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

/// Special functions, quadrature and roots, by the GNU Scientific Library (GSL).
namespace bouncelab {

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
/// @return nodes in ascending order; errors of the weights grow from 1e-15 for n = 4 to 1e-12 for n = 100
QuadratureRule gauss_legendre(int n, double lo, double hi);

/// A Gauss-Legendre rule known when compiling, for inner loops.
template <std::size_t n>
struct TabulatedRule {
  std::array<double, n> nodes;
  std::array<double, n> weights;
};

/// 6 points on [0, 1].
inline constexpr TabulatedRule<6> kGaussLegendre6{{0.033765242898423975, 0.16939530676686776, 0.3806904069584015,
                                                   0.6193095930415985, 0.8306046932331322, 0.966234757101576},
                                                  {0.08566224618958517, 0.1803807865240693, 0.23395696728634552,
                                                   0.23395696728634552, 0.1803807865240693, 0.08566224618958517}};

/// 12 points on [-1, 1]: the positive half of the nodes. The others are their negatives, with the same weights.
inline constexpr TabulatedRule<6> kGaussLegendre12Positive{
    {0.1252334085114689, 0.3678314989981802, 0.5873179542866175, 0.7699026741943047, 0.9041172563704749,
     0.9815606342467193},
    {0.2491470458134028, 0.2334925365383548, 0.2031674267230659, 0.1600783285433462, 0.1069393259953184,
     0.0471753363865118}};

/// The root of f between lo and hi, to rounding, by Brent's method.
/// @param f  continuous; of different signs at lo and hi, or 0 at one of them
/// @throws InvalidArgument where the signs are the same
double root_between(const std::function<double(double)>& f, double lo, double hi);

}  // namespace bouncelab
