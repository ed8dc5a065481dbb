// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/elementary.hpp"

#include <sleef.h>

#include "numerics/elementary_avx.hpp"

// The "cinz" functions are SLEEF's own for the same bits everywhere, whatever registers they fill.

#ifdef __wasm_simd128__
#include <wasm_simd128.h>
extern "C" v128_t Sleef_cinz_expd2_u10sse4(v128_t);  // put into the library by tools/web/build
#endif

namespace bouncelab {

#ifdef __wasm_simd128__
double exp(double x) { return wasm_f64x2_extract_lane(Sleef_cinz_expd2_u10sse4(wasm_f64x2_splat(x)), 0); }
#else
double exp(double x) { return Sleef_cinz_expd1_u10purec(x); }
#endif
double log(double x) { return Sleef_cinz_logd1_u10purec(x); }
double sin(double x) { return Sleef_cinz_sind1_u10purec(x); }
double cos(double x) { return Sleef_cinz_cosd1_u10purec(x); }

SinCos sin_cos(double x) {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u10purec(x);
  return {both.x, both.y};
}

double pow(double x, double y) {
  if (y == 0.0 || x == 1.0) return 1.0;
  return exp(y * Sleef_cinz_logd1_u35purec(x));
}

void exp_each(std::span<double> x) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx")) return exp_by_fours(x.data(), x.size());
#endif
#ifdef __wasm_simd128__
  for (; x.size() > 1; x = x.subspan(2)) wasm_v128_store(x.data(), Sleef_cinz_expd2_u10sse4(wasm_v128_load(x.data())));
#endif
  for (double& one : x) one = exp(one);
}

void log_each(std::span<double> x) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx")) return log_by_fours(x.data(), x.size());
#endif
  for (double& one : x) one = log(one);
}

}  // namespace bouncelab
