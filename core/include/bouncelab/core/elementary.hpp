// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <complex>
#include <span>

/// Elementary functions that give the same bits on every x86-64 processor and with every compiler.
///
/// The C library chooses variants with fused multiply-add where the processor has it; their last digits differ, and a
/// ball that bounces on a rough surface makes another orbit of another last digit. All that computes results takes its
/// functions from here, none from the header cmath but what IEEE 754 defines to the last bit (sqrt, fma, roundings,
/// scalings); tests/reference/no_libm_functions holds it to that.
///
/// By SLEEF's deterministic functions without fused multiply-add (Shibata & Petrogalli, IEEE TPDS 31, 1316 (2020),
/// doi:10.1109/TPDS.2019.2960333): errors of at most 1 unit in the last place unless said otherwise. Arguments outside
/// the domain give NaN or infinities as those of the C library do.
namespace bouncelab {

double exp(double x);
double expm1(double x);
double log(double x);
double log1p(double x);
double log10(double x);
double sin(double x);
double cos(double x);
double atan2(double y, double x);
/// 1 - erf(x), to 1.5 units in the last place.
double erfc(double x);
/// log |Gamma(x)|
double log_gamma(double x);

struct SinCos {
  double sin, cos;
};
/// Both at the cost of one.
SinCos sin_cos(double x);

struct Pair {
  double first, second;
};
/// exp() of two numbers, at the cost of one.
Pair exp(Pair x);

/// Of each x in its place, as many at once as the processor's registers hold; the bits are those of the functions of
/// one.
void exp_each(std::span<double> x);
void log_each(std::span<double> x);
void erfc_each(std::span<double> x);

/// exp(y log x), to 1 + 3 |y log x| units in the last place: a quarter of the time of a pow() that is good to one.
/// @param x  >= 0
double pow(double x, double y);

/// x^n, n >= 0, by multiplications.
constexpr double power(double x, int n) {
  double result = 1.0;
  for (int k = 0; k < n; ++k) result *= x;
  return result;
}
constexpr double square(double x) { return x * x; }

/// sqrt(x^2 + y^2) and of three; for values whose squares neither overflow nor underflow.
inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }
inline double hypot(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

/// r exp(i phase)
inline std::complex<double> polar(double r, double phase_rad) {
  const SinCos direction = sin_cos(phase_rad);
  return {r * direction.cos, r * direction.sin};
}
inline std::complex<double> exp(const std::complex<double>& z) { return polar(exp(z.real()), z.imag()); }

}  // namespace bouncelab
