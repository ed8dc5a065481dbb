// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "products.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define BOUNCELAB_HAS_FMA_VARIANT
#endif

// Fused multiply-add is exactly defined, so that every machine gives the same bytes as long as the order is the same:
// of each output taps 0, 8, 16 ..., then 1, 9, 17 ..., so that a wide register of samples serves several taps.

namespace bouncelab {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kChains = 8;  // registers of outputs: what an addition's latency takes
constexpr std::size_t kAtOnce = kLanes * kChains;

/// Where there are no such registers. @param n_at_once  outputs side by side
template <std::size_t n_at_once>
void correlate_plainly(const float* x, const float* taps, std::size_t n_taps, float* out) {
  std::array<float, n_at_once> sum{};
  for (std::size_t first = 0; first < std::min(kLanes, n_taps); ++first)
    for (std::size_t k = first; k < n_taps; k += kLanes)
      for (std::size_t c = 0; c < n_at_once; ++c) sum[c] = std::fma(taps[k], x[k + c], sum[c]);
  std::copy(sum.begin(), sum.end(), out);
}

#ifdef BOUNCELAB_HAS_FMA_VARIANT
#define BOUNCELAB_FMA gnu::target("avx2,fma")

template <std::size_t n_taps>
[[gnu::always_inline, BOUNCELAB_FMA]] inline void add_taps(const float* x, const float* taps, __m256* sum) {
  __m256 tap[n_taps];
  for (std::size_t t = 0; t < n_taps; ++t) tap[t] = _mm256_broadcast_ss(taps + t * kLanes);
#pragma GCC unroll 16
  for (std::size_t j = 0; j < kChains + n_taps - 1; ++j) {
    const __m256 here = _mm256_loadu_ps(x + j * kLanes);
#pragma GCC unroll 4
    for (std::size_t t = 0; t < n_taps; ++t)
      if (j >= t && j - t < kChains) sum[j - t] = _mm256_fmadd_ps(tap[t], here, sum[j - t]);
  }
}

/// kAtOnce outputs.
[[BOUNCELAB_FMA]] void correlate_by_vectors(const float* x, const float* taps, std::size_t n_taps, float* out) {
  __m256 sum[kChains];
  for (__m256& s : sum) s = _mm256_setzero_ps();
  for (std::size_t first = 0; first < kLanes; ++first) {
    std::size_t k = first;
    for (; k + 3 * kLanes < n_taps; k += 4 * kLanes) add_taps<4>(x + k, taps + k, sum);
    if (k + 2 * kLanes < n_taps)
      add_taps<3>(x + k, taps + k, sum);
    else if (k + kLanes < n_taps)
      add_taps<2>(x + k, taps + k, sum);
    else if (k < n_taps)
      add_taps<1>(x + k, taps + k, sum);
  }
  for (std::size_t c = 0; c < kChains; ++c) _mm256_storeu_ps(out + c * kLanes, sum[c]);
}

bool has_fma() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return has;
}
#else
void correlate_by_vectors(const float*, const float*, std::size_t, float*) {}
bool has_fma() { return false; }
#endif

}  // namespace

void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out) {
  assert(x.size() + 1 >= out.size() + taps.size());
  const auto many = has_fma() ? correlate_by_vectors : correlate_plainly<kAtOnce>;
  std::size_t n = 0;
  for (; n + kAtOnce <= out.size(); n += kAtOnce) many(x.data() + n, taps.data(), taps.size(), out.data() + n);
  for (; n < out.size(); ++n) correlate_plainly<1>(x.data() + n, taps.data(), taps.size(), out.data() + n);
}

}  // namespace bouncelab
