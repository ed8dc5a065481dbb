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

/// What is left over of x goes through a register that is filled up with ones.
template <std::size_t kWidth>
struct Rest {
  std::array<double, kWidth> filled;

  explicit Rest(std::span<const double> x) {
    filled.fill(1.0);
    std::copy(x.begin(), x.end(), filled.begin());
  }
  void put(std::span<double> x) const { std::copy_n(filled.begin(), x.size(), x.begin()); }
};

// The loops are compiled for the registers that they fill: between them there is nothing but the library's function.
template <class Function>
__attribute__((target("avx"))) void by_4(std::span<double> x) {
  std::size_t k = 0;
  for (; k + 4 <= x.size(); k += 4) _mm256_storeu_pd(x.data() + k, Function::of(_mm256_loadu_pd(x.data() + k)));
  if (k == x.size()) return;
  Rest<4> rest(x.subspan(k));
  _mm256_storeu_pd(rest.filled.data(), Function::of(_mm256_loadu_pd(rest.filled.data())));
  rest.put(x.subspan(k));
}
template <class Function>
__attribute__((target("avx512f"))) void by_8(std::span<double> x) {
  std::size_t k = 0;
  for (; k + 8 <= x.size(); k += 8) _mm512_storeu_pd(x.data() + k, Function::of(_mm512_loadu_pd(x.data() + k)));
  if (k == x.size()) return;
  Rest<8> rest(x.subspan(k));
  _mm512_storeu_pd(rest.filled.data(), Function::of(_mm512_loadu_pd(rest.filled.data())));
  rest.put(x.subspan(k));
}

struct Exp {
  __attribute__((target("avx"))) static __m256d of(__m256d x) { return Sleef_cinz_expd4_u10avx(x); }
  __attribute__((target("avx512f"))) static __m512d of(__m512d x) { return Sleef_cinz_expd8_u10avx512fnofma(x); }
};
struct Log {
  __attribute__((target("avx"))) static __m256d of(__m256d x) { return Sleef_cinz_logd4_u10avx(x); }
  __attribute__((target("avx512f"))) static __m512d of(__m512d x) { return Sleef_cinz_logd8_u10avx512fnofma(x); }
};
struct Erfc {
  __attribute__((target("avx"))) static __m256d of(__m256d x) { return Sleef_cinz_erfcd4_u15avx(x); }
  __attribute__((target("avx512f"))) static __m512d of(__m512d x) { return Sleef_cinz_erfcd8_u15avx512fnofma(x); }
};

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
      return by_8<Exp>(x);
    case Registers::avx:
      return by_4<Exp>(x);
    case Registers::narrow:
      break;
  }
  std::size_t k = 0;
  for (; k + 2 <= x.size(); k += 2) {
    const Pair both = exp(Pair{x[k], x[k + 1]});
    x[k] = both.first;
    x[k + 1] = both.second;
  }
  if (k < x.size()) x[k] = exp(x[k]);
}

void log_each(std::span<double> x) {
  switch (registers()) {
    case Registers::avx512:
      return by_8<Log>(x);
    case Registers::avx:
      return by_4<Log>(x);
    case Registers::narrow:
      break;
  }
  for (double& one : x) one = log(one);
}

void erfc_each(std::span<double> x) {
  switch (registers()) {
    case Registers::avx512:
      return by_8<Erfc>(x);
    case Registers::avx:
      return by_4<Erfc>(x);
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
