// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/normal_laplace.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kSqrt2Pi = 2.50662827463100050242;
constexpr double kLogSqrt2Pi = 0.91893853320467274178;
constexpr double kSqrtHalfPi = 1.25331413731550025121;
constexpr double kInvSqrt2 = 0.70710678118654752440;
constexpr double kVanished = -700.0;  // exp() of less is 0

// exp(x^2) erfc(x), x >= 0, in Cody's three pieces, each a ratio of polynomials: inline, so that loops over many
// arguments take registers full of them. Relative error below 1e-15.
// Source: Cody, Math. Comp. 23, 631 (1969), doi:10.1090/S0025-5718-1969-0247736-4.

constexpr double kNearReach = 0.46875, kMiddleReach = 4.0;  // ends of the first two pieces

// from high powers to low ones but for the numerator's highest, which comes last
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

/// Two polynomials of the same degree by Horner's rule; the denominator's highest power has the coefficient 1.
template <std::size_t n>
inline Ratio ratio(const std::array<double, n + 1>& numerator, const std::array<double, n>& denominator, double x) {
  Ratio sum{numerator[n] * x, x};
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 8
#endif
  for (std::size_t i = 0; i + 1 < n; ++i) {
    sum.numerator = (sum.numerator + numerator[i]) * x;
    sum.denominator = (sum.denominator + denominator[i]) * x;
  }
  return {sum.numerator + numerator[n - 1], sum.denominator + denominator[n - 1]};
}

/// erfc(x), x <= kNearReach: without the factor exp(x^2).
inline double erfc_near(double x) {
  const Ratio erf = ratio(kErfNumerator, kErfDenominator, x * x);
  return 1.0 - x * erf.numerator / erf.denominator;
}
inline double scaled_erfc_middle(double x) {
  const Ratio erfc = ratio(kErfcNumerator, kErfcDenominator, x);
  return erfc.numerator / erfc.denominator;
}
inline double scaled_erfc_far(double x) {
  const double y = 1.0 / (x * x);
  const Ratio tail = ratio(kTailNumerator, kTailDenominator, y);
  return (1.0 / std::sqrt(std::numbers::pi) - y * tail.numerator / tail.denominator) / x;
}

// Loops without branches: what is not wanted of a sample is computed and not taken.

/// Of phi(u) where u < 0, of the factor of Mills' ratio near 0.
inline double exp_argument(double u) {
  const double x = u * kInvSqrt2;
  const double small = x <= kNearReach ? x * x : 0.0;
  return u < 0.0 ? -0.5 * u * u : small;
}

struct Mills {
  double ratio;  ///< of |u|; where that is near 0 and u < 0 not known
  double tail;   ///< 1 - Phi(|u|), for u < 0
  double normal;
};

/// @param e  exp(exp_argument(u))
inline Mills mills(double u, double e) {
  const double x = std::abs(u) * kInvSqrt2;
  const double near = erfc_near(x), middle = scaled_erfc_middle(x), far = scaled_erfc_far(x);
  const double beyond = x <= kMiddleReach ? middle : far;
  const double ratio = kSqrtHalfPi * (x <= kNearReach ? e * near : beyond);
  const double normal = e / kSqrt2Pi;
  return {ratio, x > kNearReach ? normal * (kSqrtHalfPi * beyond) : 0.5 * near, normal};
}

/// f (b_below + b_above) = exp(exponent) sum, the share of T1 in it, and phi(z) / (T1 + T2).
struct Parts {
  Block a_tau, c_tau, z, u1, u2;
  Block exponent, sum, share_above, hazard;
};

BOUNCELAB_VECTOR_CLONES void exponents(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                                       const double* inverse_tau, Parts& __restrict p, Block& __restrict exp1,
                                       Block& __restrict exp2) {
  for (std::size_t k = 0; k < n; ++k) {
    const double a_tau = tau[k] * sides.inverse_above[k], c_tau = tau[k] * sides.inverse_below[k];
    const double z = d[k] * inverse_tau[k];
    const double u1 = a_tau - z, u2 = c_tau + z;
    const double above = a_tau * (0.5 * a_tau - z), below = c_tau * (0.5 * c_tau + z);
    const double beside = -0.5 * z * z - kLogSqrt2Pi;
    p.a_tau[k] = a_tau;
    p.c_tau[k] = c_tau;
    p.z[k] = z;
    p.u1[k] = u1;
    p.u2[k] = u2;
    const double not_above = u2 < 0.0 ? below : beside;
    p.exponent[k] = u1 < 0.0 ? above : not_above;
    exp1[k] = exp_argument(u1);
    exp2[k] = exp_argument(u2);
  }
}

/// Beyond the start of one side's exponential, u < 0, that side is whole but for its tail, and the other enters by its
/// ratio; between both starts both enter by their ratios.
BOUNCELAB_VECTOR_CLONES void sums_of_sides(std::size_t n, const Block& exp1, const Block& exp2, Parts& __restrict p) {
  for (std::size_t k = 0; k < n; ++k) {
    const double u1 = p.u1[k], u2 = p.u2[k];
    const Mills m1 = mills(u1, exp1[k]), m2 = mills(u2, exp2[k]);
    const bool is_above = u1 < 0.0, is_beyond = is_above || u2 < 0.0;
    const double normal = is_above ? m1.normal : m2.normal;
    const double whole = 1.0 - (is_above ? m1.tail : m2.tail);
    const double other = normal * (is_above ? m2.ratio : m1.ratio);
    const double sum_beyond = whole + other, share_beyond = whole / sum_beyond;
    const double mirrored = 1.0 - share_beyond;
    const double sum_beside = m1.ratio + m2.ratio;
    const double sum = is_beyond ? sum_beyond : sum_beside;
    const double share_of_beyond = is_above ? share_beyond : mirrored, share_beside = m1.ratio / sum_beside;
    p.sum[k] = sum;
    p.share_above[k] = is_beyond ? share_of_beyond : share_beside;
    p.hazard[k] = (is_beyond ? normal : 1.0) / sum;
  }
}

void parts(std::size_t n, const double* d, const SidesBlock& sides, const double* tau, const double* inverse_tau,
           Parts& p) {
  Block exp1, exp2;
  exponents(n, d, sides, tau, inverse_tau, p, exp1, exp2);
  exp_each(std::span(exp1).first(n));
  exp_each(std::span(exp2).first(n));
  sums_of_sides(n, exp1, exp2, p);
}

/// @param inverse  of exp(exponent); 0 where there is no background
BOUNCELAB_VECTOR_CLONES void densities(std::size_t n, const SidesBlock& sides, const Parts& p, const Block& inverse,
                                       double background, DensityBlock& __restrict f) {
  const double vanishing = background > 0.0 ? kVanished : -HUGE_VAL;
  for (std::size_t k = 0; k < n; ++k) {
    const double density = p.sum[k] * sides.inverse_width[k];
    const double sum = density + background * inverse[k];
    const bool vanished = p.exponent[k] < vanishing;
    // without a background exactly 1
    const double part = density / sum, share = vanished ? 0.0 : part;
    const double a_tau = p.a_tau[k], c_tau = p.c_tau[k], z = p.z[k], hazard = p.hazard[k];
    const double w1 = p.share_above[k], w2 = 1.0 - w1;
    const double d_location = w1 * sides.inverse_above[k] - w2 * sides.inverse_below[k];
    // a_tau c_tau times (f + (b_above - b_below) f' - phi(z)/tau) / f
    const double curvature =
        a_tau * c_tau * (1.0 - (sides.b_above[k] - sides.b_below[k]) * d_location) - hazard * (a_tau + c_tau);
    const double by_log_below = -share * (1.0 - sides.p_above[k] + c_tau * ((c_tau + z) * w2 - hazard));
    const double by_log_above = -share * (sides.p_above[k] + a_tau * ((a_tau - z) * w1 - hazard));
    const double by_location = share * d_location, by_log_tau = share * curvature;
    f.exponent[k] = vanished ? 0.0 : p.exponent[k];
    f.factor[k] = vanished ? background : sum;
    f.d_location[k] = vanished ? 0.0 : by_location;
    f.d_log_below[k] = vanished ? 0.0 : by_log_below;
    f.d_log_above[k] = vanished ? 0.0 : by_log_above;
    f.d_log_tau[k] = vanished ? 0.0 : by_log_tau;
  }
}

BOUNCELAB_VECTOR_CLONES void normal_cdfs(std::size_t n, const double* density_arguments, double* z) {
  for (std::size_t k = 0; k < n; ++k) {
    const double tail = mills(-std::abs(z[k]), density_arguments[k]).tail;
    z[k] = z[k] < 0.0 ? tail : 1.0 - tail;
  }
}

BOUNCELAB_VECTOR_CLONES void complete_sides(std::size_t n, SidesBlock& sides) {
  for (std::size_t k = 0; k < n; ++k) {
    const double below = sides.b_below[k], above = sides.b_above[k];
    const double sum = below + above, product = below * above;
    const double inverse = 1.0 / (sum * product);  // one division serves all
    sides.inverse_below[k] = inverse * sum * above;
    sides.inverse_above[k] = inverse * sum * below;
    sides.p_above[k] = inverse * product * above;
    sides.inverse_width[k] = inverse * product;
  }
}

}  // namespace

void SidesBlock::complete(std::size_t n) { complete_sides(n, *this); }

void SidesBlock::fill(double below, double above) {
  b_below.fill(below);
  b_above.fill(above);
  complete(kBlockSize);
}

void normal_laplace(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                    const double* inverse_tau, double background, DensityBlock& f) {
  Parts p;
  parts(n, d, sides, tau, inverse_tau, p);
  Block inverse;
  inverse.fill(0.0);
  if (background > 0.0) {
    for (std::size_t k = 0; k < n; ++k) inverse[k] = -p.exponent[k];
    exp_each(std::span(inverse).first(n));
  }
  densities(n, sides, p, inverse, background, f);
}

void normal_laplace_cdf(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                        const double* inverse_tau, double* cdf) {
  Parts p;
  parts(n, d, sides, tau, inverse_tau, p);
  std::copy_n(p.z.begin(), n, cdf);
  normal_cdf_each({cdf, n});
  exp_each(std::span(p.exponent).first(n));
  // integrate by parts: F = Phi(z) - p_above T1 + p_below T2
  for (std::size_t k = 0; k < n; ++k) {
    const double of_both = (1.0 - sides.p_above[k]) * (1.0 - p.share_above[k]) - sides.p_above[k] * p.share_above[k];
    cdf[k] += p.exponent[k] * p.sum[k] * of_both;
  }
}

void normal_cdf_each(std::span<double> z) {
  Block e;
  for (std::size_t begin = 0; begin < z.size(); begin += kBlockSize) {
    const std::size_t n = std::min(kBlockSize, z.size() - begin);
    double* const at = z.data() + begin;
    for (std::size_t k = 0; k < n; ++k) e[k] = -0.5 * at[k] * at[k];
    exp_each(std::span(e).first(n));
    normal_cdfs(n, e.data(), at);
  }
}

double mills_ratio(double u) {
  const double x = u * kInvSqrt2;
  if (x <= kNearReach) return kSqrtHalfPi * exp(x * x) * erfc_near(x);
  return kSqrtHalfPi * (x <= kMiddleReach ? scaled_erfc_middle(x) : scaled_erfc_far(x));
}

namespace {

/// Adds weight f score score^T at the points of one panel.
void add_panel(double lo, double hi, const SidesBlock& sides, const Block& tau, const Block& inverse_tau,
               Eigen::Matrix4d& sum) {
  static const QuadratureRule rule = gauss_legendre(12, -1.0, 1.0);
  const std::size_t n = rule.nodes.size();
  Block d;
  for (std::size_t i = 0; i < n; ++i) d[i] = 0.5 * (lo + hi) + 0.5 * (hi - lo) * rule.nodes[i];
  DensityBlock f;
  normal_laplace(n, d.data(), sides, tau.data(), inverse_tau.data(), 0.0, f);
  exp_each(std::span(f.exponent).first(n));
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector4d score(f.d_location[i], f.d_log_below[i], f.d_log_above[i], f.d_log_tau[i]);
    sum += 0.5 * (hi - lo) * rule.weights[i] * f.exponent[i] * f.factor[i] * score * score.transpose();
  }
}

}  // namespace

Eigen::Matrix4d normal_laplace_information(double b_below, double b_above, double tau) {
  SidesBlock sides;
  sides.fill(b_below, b_above);
  Block taus, inverse_taus;
  taus.fill(tau);
  inverse_taus.fill(1.0 / tau);
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  for (const double b : {-b_below, b_above}) {
    const double t = std::copysign(tau, b);
    const std::array<double, 8> edges{
        0.0, t, 3.0 * t, 8.0 * t, 8.0 * t + b, 8.0 * t + 3.0 * b, 8.0 * t + 10.0 * b, 8.0 * t + 40.0 * b};
    for (std::size_t k = 0; k + 1 < edges.size(); ++k)
      add_panel(std::min(edges[k], edges[k + 1]), std::max(edges[k], edges[k + 1]), sides, taus, inverse_taus,
                information);
  }
  return information;
}

namespace {

struct LogRatio {
  double value;   ///< log of Mills' ratio R(u)
  double hazard;  ///< -d log R / du = 1/R(u) - u, positive
};

LogRatio log_mills_ratio(double u) {
  const double ratio = u >= 0.0 ? mills_ratio(u) : kSqrt2Pi * exp(0.5 * u * u) - mills_ratio(-u);
  return {log(ratio), 1.0 / ratio - u};
}

}  // namespace

/// f' = 0 where R(p - z) / b_above = R(q + z) / b_below, p = tau / b_above, q = tau / b_below, z = distance / tau: of
/// its logarithm, which is nearly linear in z, by Newton's method. Derivatives by those of the equation.
ModeOffset mode_offset(double asymmetry, double rho, double near) {
  constexpr double kMostRho = 8.0;  // from there on the mean of the exponentials, to 1e-6
  constexpr int kMost = 30;
  rho = std::min(rho, kMostRho);
  const double tau = exp(rho), p = exp(rho - 0.5 * asymmetry), q = exp(rho + 0.5 * asymmetry);
  double z = near / tau;
  LogRatio above{}, below{};
  for (int i = 0; i < kMost; ++i) {
    above = log_mills_ratio(p - z);
    below = log_mills_ratio(q + z);
    const double step = -(above.value - below.value - asymmetry) / (above.hazard + below.hazard);
    z += step;
    if (std::abs(step) < 1e-12 * (1.0 + std::abs(z))) break;
  }
  const double by_z = above.hazard + below.hazard;
  const double by_asymmetry = 0.5 * (p * above.hazard + q * below.hazard) - 1.0;
  const double by_rho = q * below.hazard - p * above.hazard;
  return {tau * z, -tau * by_asymmetry / by_z, tau * (z - by_rho / by_z)};
}

}  // namespace bouncelab::fit
