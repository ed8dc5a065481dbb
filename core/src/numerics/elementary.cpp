// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/elementary.hpp"

#include <sleef.h>

#include <algorithm>
#include <array>

// The "cinz" functions are SLEEF's own for the same bits everywhere, whatever registers they fill.

#if defined(__x86_64__) && defined(__GNUC__)
#define BOUNCELAB_FOUR_AT_ONCE
#include <immintrin.h>

// SLEEF's header has those for wide registers only where everything is compiled for them
// NOLINTBEGIN(readability-identifier-naming): the library's
extern "C" {
__attribute__((target("avx"))) __m256d Sleef_cinz_expd4_u10avx(__m256d);
__attribute__((target("avx"))) __m256d Sleef_cinz_logd4_u10avx(__m256d);
}
// NOLINTEND(readability-identifier-naming)
#endif

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

#ifdef BOUNCELAB_FOUR_AT_ONCE
namespace {

// The loops are compiled for the registers that they fill: between them there is nothing but the library's function.
// What is left over goes through a register that is filled up with ones.
template <class Function>
__attribute__((target("avx"))) void four_at_once(std::span<double> x) {
  std::size_t k = 0;
  for (; k + 4 <= x.size(); k += 4) _mm256_storeu_pd(x.data() + k, Function::of(_mm256_loadu_pd(x.data() + k)));
  if (k == x.size()) return;
  std::array<double, 4> rest{1.0, 1.0, 1.0, 1.0};
  std::copy(x.begin() + static_cast<std::ptrdiff_t>(k), x.end(), rest.begin());
  _mm256_storeu_pd(rest.data(), Function::of(_mm256_loadu_pd(rest.data())));
  std::copy_n(rest.begin(), x.size() - k, x.begin() + static_cast<std::ptrdiff_t>(k));
}

struct Exp {
  __attribute__((target("avx"))) static __m256d of(__m256d x) { return Sleef_cinz_expd4_u10avx(x); }
};
struct Log {
  __attribute__((target("avx"))) static __m256d of(__m256d x) { return Sleef_cinz_logd4_u10avx(x); }
};

}  // namespace
#endif

void exp_each(std::span<double> x) {
#ifdef BOUNCELAB_FOUR_AT_ONCE
  if (__builtin_cpu_supports("avx")) return four_at_once<Exp>(x);
#endif
#ifdef __wasm_simd128__
  for (; x.size() > 1; x = x.subspan(2)) wasm_v128_store(x.data(), Sleef_cinz_expd2_u10sse4(wasm_v128_load(x.data())));
#endif
  for (double& one : x) one = exp(one);
}

void log_each(std::span<double> x) {
#ifdef BOUNCELAB_FOUR_AT_ONCE
  if (__builtin_cpu_supports("avx")) return four_at_once<Log>(x);
#endif
  for (double& one : x) one = log(one);
}

}  // namespace bouncelab
