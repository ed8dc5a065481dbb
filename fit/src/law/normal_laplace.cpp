// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/normal_laplace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/quadrature.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kSqrt2Pi = 2.50662827463100050242;
constexpr double kLogSqrt2Pi = 0.91893853320467274178;
constexpr double kSqrtHalfPi = 1.25331413731550025121;
constexpr double kInvSqrt2 = 0.70710678118654752440;
// exp(-u^2/2) is below 1e-17 from here on: the other side of the peak and the normal no longer matter
constexpr double kFar = 8.8;

// Cody's coefficients, from high powers to low ones but for the numerator's highest, which comes last
constexpr std::array<double, 5> kErfNumerator{3.1611237438705656, 113.864154151050156, 377.485237685302021,
                                              3209.37758913846947, 0.185777706184603153};
constexpr std::array<double, 4> kErfDenominator{23.6012909523441209, 244.024637934444173, 1282.61652607737228,
                                                2844.23683343917062};
constexpr std::array<double, 9> kErfcNumerator{0.564188496988670089, 8.88314979438837594, 66.1191906371416295,
                                               298.635138197400131,  881.95222124176909,  1712.04761263407058,
                                               2051.07837782607147,  1230.33935479799725, 2.15311535474403846e-8};
constexpr std::array<double, 8> kErfcDenominator{15.7449261107098347, 117.693950891312499, 537.181101862009858,
                                                 1621.38957456669019, 3290.79923573345963, 4362.61909014324716,
                                                 3439.36767414372164, 1230.33935480374942};
constexpr std::array<double, 6> kTailNumerator{0.305326634961232344,  0.360344899949804439,   0.125781726111229246,
                                               0.0160837851487422766, 6.58749161529837803e-4, 0.0163153871373020978};
constexpr std::array<double, 5> kTailDenominator{2.56852019228982242, 1.87295284992346725, 0.527905102951428412,
                                                 0.0605183413124413191, 0.00233520497626869185};

struct Ratio {
  double numerator, denominator;
};
constexpr double kErfReach = 0.46875;  // of the approximation of erf(x) / x

/// Two polynomials of the same degree by Horner's rule; the denominator's highest power has the coefficient 1.
template <std::size_t n>
Ratio ratio(const std::array<double, n + 1>& numerator, const std::array<double, n>& denominator, double x) {
  Ratio sum{numerator[n] * x, x};
  for (std::size_t i = 0; i + 1 < n; ++i) {
    sum.numerator = (sum.numerator + numerator[i]) * x;
    sum.denominator = (sum.denominator + denominator[i]) * x;
  }
  return {sum.numerator + numerator[n - 1], sum.denominator + denominator[n - 1]};
}

/// 1 - Phi(u), u >= 0. @param density  phi(u)
double upper_tail(double u, double density) {
  const double x = u * kInvSqrt2;
  if (x > kErfReach) return density * mills_ratio(u);
  const Ratio erf = ratio(kErfNumerator, kErfDenominator, x * x);
  return 0.5 * (1.0 - x * erf.numerator / erf.denominator);
}

/// f (b_below + b_above) = exp(exponent) sum, the share of T1 in it, and phi(z) / (T1 + T2)
struct Parts {
  double exponent = 0.0;
  double sum = 1.0;
  double share_above = 0.0;
  double hazard = 0.0;
};

/// The side d >= 0 with u1 = a tau - z < 0: exp(E) factored out, E = (a tau)^2 / 2 - a d.
Parts parts_beyond(double u1, double u2, double a_tau, double z) {
  const double exponent = a_tau * (0.5 * a_tau - z);
  if (u1 < -kFar) return {exponent, 1.0, 1.0, 0.0};
  const double normal = exp(-0.5 * u1 * u1) / kSqrt2Pi;  // phi(u1) = phi(z) exp(-E)
  const double t1 = 1.0 - upper_tail(-u1, normal);
  const double t2 = normal * mills_ratio(u2);
  const double sum = t1 + t2;
  return {exponent, sum, t1 / sum, normal / sum};
}

Parts parts(double a_tau, double c_tau, double z) {
  const double u1 = a_tau - z, u2 = c_tau + z;
  if (u1 < 0.0) return parts_beyond(u1, u2, a_tau, z);
  if (u2 < 0.0) {
    Parts mirrored = parts_beyond(u2, u1, c_tau, -z);
    mirrored.share_above = 1.0 - mirrored.share_above;
    return mirrored;
  }
  const double r1 = mills_ratio(u1), r2 = mills_ratio(u2);
  return {-0.5 * z * z - kLogSqrt2Pi, r1 + r2, r1 / (r1 + r2), 1.0 / (r1 + r2)};
}

NormalLaplace pure_laplace(double d, double b_below, double b_above) {
  const double p_above = b_above / (b_below + b_above), p_below = 1.0 - p_above;
  const double peak = 1.0 / (b_below + b_above);
  if (d > 0.0) return {-d / b_above, peak, 1.0 / b_above, -p_below, d / b_above - p_above, 0.0};
  if (d < 0.0) return {d / b_below, peak, -1.0 / b_below, -d / b_below - p_below, -p_above, 0.0};
  return {0.0, peak, 0.5 * (1.0 / b_above - 1.0 / b_below), -p_below, -p_above, 0.0};
}

Eigen::Matrix4d pure_laplace_information(double b_below, double b_above) {
  const double p = b_above / (b_below + b_above), q = 1.0 - p;
  const double cross = 1.0 / (b_below + b_above);
  Eigen::Matrix4d information;
  information << 1.0 / (b_below * b_above), -cross, cross, 0.0,  //
      -cross, q * (2.0 - q), -p * q, 0.0,                        //
      cross, -p * q, p * (2.0 - p), 0.0,                         //
      0.0, 0.0, 0.0, 0.0;
  return information;
}

void add_panel(Eigen::Matrix4d& sum, double lo, double hi, double b_below, double b_above, double tau) {
  const double middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
  for (std::size_t k = 0; k < kGaussLegendre12Positive.nodes.size(); ++k) {
    for (const double side : {-1.0, 1.0}) {
      const NormalLaplace f =
          normal_laplace(middle + side * half * kGaussLegendre12Positive.nodes[k], b_below, b_above, tau);
      const Eigen::Vector4d score(f.d_location, f.d_log_below, f.d_log_above, f.d_log_tau);
      sum += std::abs(half) * kGaussLegendre12Positive.weights[k] * exp(f.log_density()) * score * score.transpose();
    }
  }
}

}  // namespace

double scaled_erfc(double x) {
  if (x <= kErfReach) {
    const double y = x * x;
    const Ratio erf = ratio(kErfNumerator, kErfDenominator, y);
    return exp(y) * (1.0 - x * erf.numerator / erf.denominator);
  }
  if (x <= 4.0) {
    const Ratio erfc = ratio(kErfcNumerator, kErfcDenominator, x);
    return erfc.numerator / erfc.denominator;
  }
  const double y = 1.0 / (x * x);
  const Ratio tail = ratio(kTailNumerator, kTailDenominator, y);
  return (1.0 / std::sqrt(std::numbers::pi) - y * tail.numerator / tail.denominator) / x;
}

double mills_ratio(double u) { return kSqrtHalfPi * scaled_erfc(u * kInvSqrt2); }

LaplaceSides laplace_sides(double b_below, double b_above) {
  const double sum = b_below + b_above, product = b_below * b_above;
  const double inverse = 1.0 / (sum * product);  // one division serves all
  return {b_below,          b_above, inverse * sum * b_above, inverse * sum * b_below, inverse * product * b_above,
          inverse * product};
}

double NormalLaplace::log_density() const { return exponent + log(factor); }

NormalLaplace normal_laplace(double d, const LaplaceSides& sides, double tau, double inverse_tau, double background) {
  constexpr double kVanished = -700.0;  // exp() of less is 0
  const double a_tau = tau * sides.inverse_above, c_tau = tau * sides.inverse_below, z = d * inverse_tau;
  const Parts f = parts(a_tau, c_tau, z);
  double density = f.sum * sides.inverse_width, share = 1.0;  // over exp(exponent)
  if (background > 0.0) {
    if (f.exponent < kVanished) return {0.0, background, 0.0, 0.0, 0.0, 0.0};
    const double sum = density + background * exp(-f.exponent);
    share = density / sum;
    density = sum;
  }
  const double w1 = f.share_above, w2 = 1.0 - w1;
  const double d_location = w1 * sides.inverse_above - w2 * sides.inverse_below;
  // a_tau c_tau times (f + (b_above - b_below) f' - phi(z)/tau) / f
  const double curvature =
      a_tau * c_tau * (1.0 - (sides.b_above - sides.b_below) * d_location) - f.hazard * (a_tau + c_tau);
  return {f.exponent,
          density,
          share * d_location,
          -share * (1.0 - sides.p_above + c_tau * ((c_tau + z) * w2 - f.hazard)),
          -share * (sides.p_above + a_tau * ((a_tau - z) * w1 - f.hazard)),
          share * curvature};
}

NormalLaplace normal_laplace(double d, double b_below, double b_above, double tau) {
  if (!(tau > 0.0)) return pure_laplace(d, b_below, b_above);
  return normal_laplace(d, laplace_sides(b_below, b_above), tau, 1.0 / tau);
}

double normal_laplace_cdf(double d, double b_below, double b_above, double tau) {
  const double p_above = b_above / (b_below + b_above);
  if (!(tau > 0.0)) return d > 0.0 ? 1.0 - p_above * exp(-d / b_above) : (1.0 - p_above) * exp(d / b_below);
  // integrate by parts: F = Phi(z) - p_above T1 + p_below T2
  const Parts f = parts(tau / b_above, tau / b_below, d / tau);
  const double sum = exp(f.exponent) * f.sum;
  const double phi_cdf = 0.5 * erfc(-d / tau * kInvSqrt2);
  return phi_cdf + sum * ((1.0 - p_above) * (1.0 - f.share_above) - p_above * f.share_above);
}

Eigen::Matrix4d normal_laplace_information(double b_below, double b_above, double tau) {
  if (!(tau > 1e-6 * std::min(b_below, b_above))) return pure_laplace_information(b_below, b_above);
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const double side : {-1.0, 1.0}) {
    const double b = side > 0.0 ? b_above : b_below;
    const std::array<double, 8> edges{
        0.0, tau, 3.0 * tau, 8.0 * tau, 8.0 * tau + b, 8.0 * tau + 3.0 * b, 8.0 * tau + 10.0 * b, 8.0 * tau + 40.0 * b};
    for (std::size_t k = 0; k + 1 < edges.size(); ++k)
      add_panel(sum, side * edges[k], side * edges[k + 1], b_below, b_above, tau);
  }
  return sum;
}

}  // namespace bouncelab::fit
