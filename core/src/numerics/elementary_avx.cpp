// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled for AVX, for which SLEEF's header declares functions of four numbers: nothing but these loops may stand
// here, and no template of the standard library, which the linker would take for the rest of the program too.
#include "numerics/elementary_avx.hpp"

#include <immintrin.h>
#include <sleef.h>

namespace bouncelab {
namespace {

/// What is left over goes through a register that is filled up with ones.
template <class Function>
void by_fours(double* x, std::size_t n, Function function) {
  std::size_t k = 0;
  for (; k + 4 <= n; k += 4) _mm256_storeu_pd(x + k, function(_mm256_loadu_pd(x + k)));
  if (k == n) return;
  double rest[4] = {1.0, 1.0, 1.0, 1.0};
  for (std::size_t j = k; j < n; ++j) rest[j - k] = x[j];
  _mm256_storeu_pd(rest, function(_mm256_loadu_pd(rest)));
  for (std::size_t j = k; j < n; ++j) x[j] = rest[j - k];
}

}  // namespace

void exp_by_fours(double* x, std::size_t n) {
  by_fours(x, n, [](__m256d four) { return Sleef_cinz_expd4_u10avx(four); });
}
void log_by_fours(double* x, std::size_t n) {
  by_fours(x, n, [](__m256d four) { return Sleef_cinz_logd4_u10avx(four); });
}

}  // namespace bouncelab
