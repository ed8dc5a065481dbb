// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "bouncelab/audio/dsp/kernels.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define BOUNCELAB_HAS_FMA_VARIANT
#endif

// Fused multiply-add is exactly defined, so that every machine gives the same bytes as long as the order is the same:
// of each output taps 0, 8, 16 ..., then 1, 9, 17 ..., so that a wide register of samples serves several taps.

namespace bouncelab::audio {
namespace {

constexpr std::size_t kStride = 8;
constexpr std::size_t kAtOnce = 64;  // outputs: what an addition's latency takes

/// Where there are no such registers. @param n_at_once  outputs side by side
template <std::size_t n_at_once>
void correlate_plainly(const float* x, const float* taps, std::size_t n_taps, float* out) {
  std::array<float, n_at_once> sum{};
  for (std::size_t first = 0; first < std::min(kStride, n_taps); ++first)
    for (std::size_t k = first; k < n_taps; k += kStride)
      for (std::size_t c = 0; c < n_at_once; ++c) sum[c] = std::fma(taps[k], x[k + c], sum[c]);
  std::copy(sum.begin(), sum.end(), out);
}

#ifdef BOUNCELAB_HAS_FMA_VARIANT
/// kAtOnce outputs. Registers of samples are kept in a ring: the next tap needs all but one of them again.
[[gnu::target("avx2,fma")]] void correlate_by_256_bits(const float* x, const float* taps, std::size_t n_taps,
                                                       float* out) {
  constexpr std::size_t kChains = kAtOnce / 8;
  __m256 sum[kChains];
  for (std::size_t c = 0; c < kChains; ++c) sum[c] = _mm256_setzero_ps();
  for (std::size_t first = 0; first < kStride; ++first) {
    __m256 ring[kChains];
    for (std::size_t c = 0; c < kChains; ++c) ring[c] = _mm256_loadu_ps(x + first + c * kStride);
    for (std::size_t k = first; k < n_taps;) {
#pragma GCC unroll 8
      for (std::size_t i = 0; i < kChains; ++i) {
        const __m256 tap = _mm256_set1_ps(taps[k]);
#pragma GCC unroll 8
        for (std::size_t c = 0; c < kChains; ++c) sum[c] = _mm256_fmadd_ps(tap, ring[(c + i) % kChains], sum[c]);
        k += kStride;
        if (k >= n_taps) break;
        ring[i] = _mm256_loadu_ps(x + k + (kChains - 1) * kStride);
      }
    }
  }
  for (std::size_t c = 0; c < kChains; ++c) _mm256_storeu_ps(out + c * 8, sum[c]);
}

/// 2 kAtOnce outputs.
[[gnu::target("avx512f")]] void correlate_by_512_bits(const float* x, const float* taps, std::size_t n_taps,
                                                      float* out) {
  constexpr std::size_t kChains = 2 * kAtOnce / 16;
  constexpr std::size_t kRing = 2 * kChains - 1;  // each register holds two strides
  __m512 sum[kChains];
  for (std::size_t c = 0; c < kChains; ++c) sum[c] = _mm512_setzero_ps();
  for (std::size_t first = 0; first < kStride; ++first) {
    __m512 ring[kRing];
    for (std::size_t c = 0; c < kRing; ++c) ring[c] = _mm512_loadu_ps(x + first + c * kStride);
    for (std::size_t k = first; k < n_taps;) {
#pragma GCC unroll 15
      for (std::size_t i = 0; i < kRing; ++i) {
        const __m512 tap = _mm512_set1_ps(taps[k]);
#pragma GCC unroll 8
        for (std::size_t c = 0; c < kChains; ++c) sum[c] = _mm512_fmadd_ps(tap, ring[(2 * c + i) % kRing], sum[c]);
        k += kStride;
        if (k >= n_taps) break;
        ring[i] = _mm512_loadu_ps(x + k + (kRing - 1) * kStride);
      }
    }
  }
  for (std::size_t c = 0; c < kChains; ++c) _mm512_storeu_ps(out + c * 16, sum[c]);
}

const bool kHas256 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
const bool kHas512 = __builtin_cpu_supports("avx512f");
#else
void correlate_by_256_bits(const float*, const float*, std::size_t, float*) {}
void correlate_by_512_bits(const float*, const float*, std::size_t, float*) {}
constexpr bool kHas256 = false;
constexpr bool kHas512 = false;
#endif

}  // namespace

void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out) {
  assert(x.size() + 1 >= out.size() + taps.size());
  std::size_t n = 0;
  const auto by = [&](auto kernel, std::size_t n_at_once) {
    for (; n + n_at_once <= out.size(); n += n_at_once) kernel(x.data() + n, taps.data(), taps.size(), out.data() + n);
  };
  if (kHas512) by(correlate_by_512_bits, 2 * kAtOnce);
  by(kHas256 ? correlate_by_256_bits : correlate_plainly<kAtOnce>, kAtOnce);
  by(correlate_plainly<1>, 1);
}

}  // namespace bouncelab::audio
