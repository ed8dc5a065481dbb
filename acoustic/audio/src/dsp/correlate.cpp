// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cassert>
#include <utility>
#include <vector>

#include "bouncelab/audio/dsp.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define BOUNCELAB_HAS_FMA_VARIANT
#endif

// Of each output taps 0, 8, 16 ... are added, then 1, 9, 17 ..., so that a register of eight samples, loaded once,
// serves several taps. For the 50 taps of a detection's linear prediction that is 8 times as fast as a plain loop that
// the compiler vectorises (tests/bench/kernels_bench.cpp), and 2.7 times as fast as one whose sums it keeps in
// registers: a tenth of the time of a whole detection.

namespace bouncelab::audio {
namespace {

constexpr std::size_t kStride = 8;
constexpr std::size_t kOutputs = 16;  // at once

#ifdef BOUNCELAB_HAS_FMA_VARIANT
constexpr std::size_t kMostTaps = 7;  // that have registers beside the samples that they need
constexpr std::size_t kOutputsInCache = std::size_t{1}
                                        << 10;  // outputs: these and their samples stay in the nearest cache

/// Adds n_taps taps, each kStride after the one before, to n outputs, a multiple of kOutputs. Two outputs a turn, each
/// of eight, with the registers of samples in a ring: the next turn needs all but two of them again.
/// @tparam is_first  the outputs are set, not added to
template <std::size_t n_taps, bool is_first>
[[gnu::target("avx2,fma")]] void add_taps(const float* x, const float* taps, float* out, std::size_t n) {
  constexpr std::size_t kHeld = n_taps - 1;
  __m256 tap[n_taps];
  __m256 ring[n_taps + 1];
#pragma GCC unroll 8
  for (std::size_t j = 0; j < n_taps; ++j) tap[j] = _mm256_set1_ps(taps[j * kStride]);
#pragma GCC unroll 8
  for (std::size_t j = 0; j < kHeld; ++j) ring[j] = _mm256_loadu_ps(x + j * kStride);
  for (std::size_t k = 0; k < n; k += kOutputs) {
    ring[kHeld] = _mm256_loadu_ps(x + k + kHeld * kStride);
    ring[n_taps] = _mm256_loadu_ps(x + k + n_taps * kStride);
    __m256 low = is_first ? _mm256_setzero_ps() : _mm256_loadu_ps(out + k);
    __m256 high = is_first ? _mm256_setzero_ps() : _mm256_loadu_ps(out + k + kStride);
#pragma GCC unroll 8
    for (std::size_t j = 0; j < n_taps; ++j) {
      low = _mm256_fmadd_ps(tap[j], ring[j], low);
      high = _mm256_fmadd_ps(tap[j], ring[j + 1], high);
    }
    _mm256_storeu_ps(out + k, low);
    _mm256_storeu_ps(out + k + kStride, high);
#pragma GCC unroll 8
    for (std::size_t j = 0; j < kHeld; ++j) ring[j] = ring[j + 2];
  }
}

using AddTaps = void (*)(const float*, const float*, float*, std::size_t);
template <bool is_first, std::size_t... n_less_one>
constexpr std::array<AddTaps, kMostTaps> add_taps_of(std::index_sequence<n_less_one...>) {
  return {add_taps<n_less_one + 1, is_first>...};
}

/// n outputs, a multiple of kOutputs.
void correlate_by_256_bits(const float* x, const float* taps, std::size_t n_taps, float* out, std::size_t n) {
  static constexpr auto kSet = add_taps_of<true>(std::make_index_sequence<kMostTaps>());
  static constexpr auto kAdd = add_taps_of<false>(std::make_index_sequence<kMostTaps>());
  for (std::size_t at = 0; at < n; at += kOutputsInCache)
    for (std::size_t first = 0; first < std::min(kStride, n_taps); ++first) {
      std::size_t n_left = (n_taps - first + kStride - 1) / kStride;
      for (std::size_t k = first; n_left > 0;) {
        const std::size_t n_parts = (n_left + kMostTaps - 1) / kMostTaps;
        const std::size_t n_here = (n_left + n_parts - 1) / n_parts;  // parts of equal size, as far as that goes
        (k == 0 ? kSet : kAdd)[n_here - 1](x + at + k, taps + k, out + at, std::min(kOutputsInCache, n - at));
        k += n_here * kStride;
        n_left -= n_here;
      }
    }
}

const bool kHas256 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
void correlate_by_256_bits(const float*, const float*, std::size_t, float*, std::size_t) {}
constexpr bool kHas256 = false;
#endif

/// n outputs, a multiple of kOutputs.
void correlate_whole(const float* x, const float* taps, std::size_t n_taps, float* out, std::size_t n) {
  if (kHas256 && n_taps > 0) return correlate_by_256_bits(x, taps, n_taps, out, n);
  for (std::size_t at = 0; at < n; at += kOutputs) {
    std::array<float, kOutputs> sum{};
    for (std::size_t k = 0; k < n_taps; ++k)
      for (std::size_t c = 0; c < kOutputs; ++c) sum[c] += taps[k] * x[at + k + c];
    std::copy(sum.begin(), sum.end(), out + at);
  }
}

}  // namespace

void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out) {
  assert(x.size() + 1 >= out.size() + taps.size());
  const std::size_t n = out.size(), n_whole = n - n % kOutputs;
  correlate_whole(x.data(), taps.data(), taps.size(), out.data(), n_whole);
  if (n_whole == n) return;
  if (n > kOutputs) {  // of the last ones some are computed twice, which takes less time than one by one
    const std::size_t last = n - kOutputs;
    return correlate_whole(x.data() + last, taps.data(), taps.size(), out.data() + last, kOutputs);
  }
  std::vector<float> padded(taps.size() + kOutputs), sums(kOutputs);
  std::copy_n(x.begin(), n + taps.size() - 1, padded.begin());
  correlate_whole(padded.data(), taps.data(), taps.size(), sums.data(), kOutputs);
  std::copy_n(sums.begin(), n, out.begin());
}

}  // namespace bouncelab::audio
