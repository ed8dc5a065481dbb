// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/distributions.hpp"

#include <cmath>

#include "bouncelab/core/elementary.hpp"

// Series and continued fractions of the incomplete gamma and beta functions: Olver et al., NIST Handbook of
// Mathematical Functions (2010), 8.7.1, 8.9.2 and 8.17.22, the fractions by Lentz' method.

namespace bouncelab::fit {
namespace {

constexpr double kTiny = 1e-300;
constexpr double kConverged = 1e-16;
constexpr int kMostTerms = 100000;

/// b_0 + a_1/(b_1 + a_2/(b_2 + ...)), built up term by term.
class ContinuedFraction {
 public:
  explicit ContinuedFraction(double b_0) : value_(b_0), c_(b_0) {}
  /// @return whether the value no longer changes
  bool add(double a, double b) {
    d_ = 1.0 / not_zero(b + a * d_);
    c_ = not_zero(b + a / c_);
    value_ *= c_ * d_;
    return std::abs(c_ * d_ - 1.0) < kConverged;
  }
  double value() const { return value_; }

 private:
  static double not_zero(double x) { return x == 0.0 ? kTiny : x; }
  double value_, c_, d_ = 0.0;
};

double lower_gamma_series(double a, double x) {
  double term = 1.0 / a, sum = term;
  for (int k = 1; k < kMostTerms && term > kConverged * sum; ++k) sum += term *= x / (a + k);
  return sum;
}

double upper_gamma_fraction(double a, double x) {
  ContinuedFraction f(x + 1.0 - a);
  for (int k = 1; k < kMostTerms; ++k)
    if (f.add(k * (a - k), x + 2.0 * k + 1.0 - a)) break;
  return 1.0 / f.value();
}

/// The fraction of I_x(a, b), x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  ContinuedFraction f(1.0);
  for (int m = 0; m < kMostTerms; ++m) {
    if (m > 0 && f.add(m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)), 1.0)) break;
    if (f.add(-(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)), 1.0)) break;
  }
  return 1.0 / f.value();
}

/// Regularized incomplete beta function I_x(a, b). @param y  1 - x
double incomplete_beta(double a, double b, double x, double y) {
  if (!(x > 0.0)) return 0.0;
  if (!(y > 0.0)) return 1.0;
  const double front = exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * log(x) + b * log(y));
  return x < (a + 1.0) / (a + b + 2.0) ? front * beta_fraction(a, b, x) / a : 1.0 - front * beta_fraction(b, a, y) / b;
}

}  // namespace

double chi2_survival(double chi2, double ndf) {
  const double a = 0.5 * ndf, x = 0.5 * chi2;
  if (!(x > 0.0)) return x <= 0.0 ? 1.0 : x;
  const double front = exp(a * log(x) - x - std::lgamma(a));
  return x < a + 1.0 ? 1.0 - front * lower_gamma_series(a, x) : front * upper_gamma_fraction(a, x);
}

double student_t_below(double t, double nu) {
  const double square_sum = nu + t * t;
  const double tail = 0.5 * incomplete_beta(0.5 * nu, 0.5, nu / square_sum, t * t / square_sum);
  return t > 0.0 ? 1.0 - tail : tail;
}

double f_survival(double f, double d1, double d2) {
  if (!(f > 0.0)) return f <= 0.0 ? 1.0 : f;
  if (std::isinf(f)) return 0.0;
  const double sum = d2 + d1 * f;
  return incomplete_beta(0.5 * d2, 0.5 * d1, d2 / sum, d1 * f / sum);
}

double student_t_quantile(double p, double nu) {
  double lo = 0.0, hi = 1.0;
  while (student_t_below(hi, nu) < p && hi < 1e300) hi *= 2.0;
  for (double middle = 0.5 * (lo + hi); middle > lo && middle < hi; middle = 0.5 * (lo + hi))
    (student_t_below(middle, nu) < p ? lo : hi) = middle;
  return hi;
}

}  // namespace bouncelab::fit
