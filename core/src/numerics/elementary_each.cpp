// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "bouncelab/core/elementary.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

// SLEEF's header has those for wide registers only where everything is compiled for them
// NOLINTBEGIN(readability-identifier-naming): the library's
extern "C" {
__attribute__((target("avx"))) __m256d Sleef_cinz_expd4_u10avx(__m256d);
__attribute__((target("avx"))) __m256d Sleef_cinz_logd4_u10avx(__m256d);
__attribute__((target("avx"))) __m256d Sleef_cinz_erfcd4_u15avx(__m256d);
__attribute__((target("avx512f"))) __m512d Sleef_cinz_erfcd8_u15avx512fnofma(__m512d);
__attribute__((target("avx512f"))) __m512d Sleef_cinz_expd8_u10avx512fnofma(__m512d);
__attribute__((target("avx512f"))) __m512d Sleef_cinz_logd8_u10avx512fnofma(__m512d);
}
// NOLINTEND(readability-identifier-naming)

namespace bouncelab {
namespace {

/// What is left over goes through a register that is filled up with ones.
template <std::size_t kWidth, class Whole>
void in_registers(std::span<double> x, const Whole& whole) {
  std::size_t k = 0;
  for (; k + kWidth <= x.size(); k += kWidth) whole(x.data() + k);
  if (k == x.size()) return;
  std::array<double, kWidth> rest;
  rest.fill(1.0);
  std::copy(x.begin() + static_cast<std::ptrdiff_t>(k), x.end(), rest.begin());
  whole(rest.data());
  std::copy_n(rest.begin(), x.size() - k, x.begin() + static_cast<std::ptrdiff_t>(k));
}

__attribute__((target("avx"))) void exp_of_4(double* x) {
  _mm256_storeu_pd(x, Sleef_cinz_expd4_u10avx(_mm256_loadu_pd(x)));
}
__attribute__((target("avx"))) void log_of_4(double* x) {
  _mm256_storeu_pd(x, Sleef_cinz_logd4_u10avx(_mm256_loadu_pd(x)));
}
__attribute__((target("avx"))) void erfc_of_4(double* x) {
  _mm256_storeu_pd(x, Sleef_cinz_erfcd4_u15avx(_mm256_loadu_pd(x)));
}
__attribute__((target("avx512f"))) void erfc_of_8(double* x) {
  _mm512_storeu_pd(x, Sleef_cinz_erfcd8_u15avx512fnofma(_mm512_loadu_pd(x)));
}
__attribute__((target("avx512f"))) void exp_of_8(double* x) {
  _mm512_storeu_pd(x, Sleef_cinz_expd8_u10avx512fnofma(_mm512_loadu_pd(x)));
}
__attribute__((target("avx512f"))) void log_of_8(double* x) {
  _mm512_storeu_pd(x, Sleef_cinz_logd8_u10avx512fnofma(_mm512_loadu_pd(x)));
}

enum class Registers { narrow, avx, avx512 };
Registers registers() {
  static const Registers widest = __builtin_cpu_supports("avx512f") ? Registers::avx512
                                  : __builtin_cpu_supports("avx")   ? Registers::avx
                                                                    : Registers::narrow;
  return widest;
}

}  // namespace

void exp_each(std::span<double> x) {
  switch (registers()) {
    case Registers::avx512:
      return in_registers<8>(x, exp_of_8);
    case Registers::avx:
      return in_registers<4>(x, exp_of_4);
    case Registers::narrow:
      break;
  }
  in_registers<2>(x, [](double* two) {
    const Pair both = exp(Pair{two[0], two[1]});
    two[0] = both.first;
    two[1] = both.second;
  });
}

void log_each(std::span<double> x) {
  switch (registers()) {
    case Registers::avx512:
      return in_registers<8>(x, log_of_8);
    case Registers::avx:
      return in_registers<4>(x, log_of_4);
    case Registers::narrow:
      break;
  }
  for (double& one : x) one = log(one);
}

void erfc_each(std::span<double> x) {
  switch (registers()) {
    case Registers::avx512:
      return in_registers<8>(x, erfc_of_8);
    case Registers::avx:
      return in_registers<4>(x, erfc_of_4);
    case Registers::narrow:
      break;
  }
  for (double& one : x) one = erfc(one);
}

}  // namespace bouncelab

#else

namespace bouncelab {

void exp_each(std::span<double> x) {
  for (double& one : x) one = exp(one);
}
void log_each(std::span<double> x) {
  for (double& one : x) one = log(one);
}
void erfc_each(std::span<double> x) {
  for (double& one : x) one = erfc(one);
}

}  // namespace bouncelab

#endif
