// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

/// exp(x^2) erfc(x), x >= 0, in Cody's three pieces, each a ratio of polynomials: inline, so that loops over many
/// arguments take registers full of them.
/// Source: Cody, Math. Comp. 23, 631 (1969), doi:10.1090/S0025-5718-1969-0247736-4.
namespace bouncelab::fit::cody {

inline constexpr double kNearReach = 0.46875, kMiddleReach = 4.0;  ///< ends of the first two pieces

// from high powers to low ones but for the numerator's highest, which comes last
inline constexpr std::array<double, 5> kErfNumerator{3.1611237438705656, 113.864154151050156, 377.485237685302021,
                                                     3209.37758913846947, 0.185777706184603153};
inline constexpr std::array<double, 4> kErfDenominator{23.6012909523441209, 244.024637934444173, 1282.61652607737228,
                                                       2844.23683343917062};
inline constexpr std::array<double, 9> kErfcNumerator{
    0.564188496988670089, 8.88314979438837594, 66.1191906371416295, 298.635138197400131,   881.95222124176909,
    1712.04761263407058,  2051.07837782607147, 1230.33935479799725, 2.15311535474403846e-8};
inline constexpr std::array<double, 8> kErfcDenominator{15.7449261107098347, 117.693950891312499, 537.181101862009858,
                                                        1621.38957456669019, 3290.79923573345963, 4362.61909014324716,
                                                        3439.36767414372164, 1230.33935480374942};
inline constexpr std::array<double, 6> kTailNumerator{0.305326634961232344,   0.360344899949804439,
                                                      0.125781726111229246,   0.0160837851487422766,
                                                      6.58749161529837803e-4, 0.0163153871373020978};
inline constexpr std::array<double, 5> kTailDenominator{2.56852019228982242, 1.87295284992346725, 0.527905102951428412,
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

}  // namespace bouncelab::fit::cody
