// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/elementary.hpp"

#include <sleef.h>

// The "cinz" functions are SLEEF's own for the same bits everywhere; "purec" and "sse2" run on every x86-64 processor.

namespace bouncelab {

double exp(double x) { return Sleef_cinz_expd1_u10purec(x); }
double expm1(double x) { return Sleef_cinz_expm1d1_u10purec(x); }
double log(double x) { return Sleef_cinz_logd1_u10purec(x); }
double log1p(double x) { return Sleef_cinz_log1pd1_u10purec(x); }
double log10(double x) { return Sleef_cinz_log10d1_u10purec(x); }
double sin(double x) { return Sleef_cinz_sind1_u10purec(x); }
double cos(double x) { return Sleef_cinz_cosd1_u10purec(x); }
double atan2(double y, double x) { return Sleef_cinz_atan2d1_u10purec(y, x); }
double erfc(double x) { return Sleef_cinz_erfcd1_u15purec(x); }
double log_gamma(double x) { return Sleef_cinz_lgammad1_u10purec(x); }

SinCos sin_cos(double x) {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u10purec(x);
  return {both.x, both.y};
}

Pair exp(Pair x) {
#ifdef __SSE2__
  const __m128d both = Sleef_cinz_expd2_u10sse2(_mm_setr_pd(x.first, x.second));
  return {_mm_cvtsd_f64(both), _mm_cvtsd_f64(_mm_unpackhi_pd(both, both))};
#else
  return {exp(x.first), exp(x.second)};
#endif
}

double pow(double x, double y) {
  if (y == 0.0 || x == 1.0) return 1.0;
  return exp(y * Sleef_cinz_logd1_u35purec(x));
}

}  // namespace bouncelab
