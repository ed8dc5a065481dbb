// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define BOUNCELAB_HAS_FMA_VARIANT
#endif

// Fused multiply-add is exactly defined, so that every processor gives the same bytes as long as the order is the same:
// of each output taps 0, 8, 16 ..., then 1, 9, 17 ..., so that a register of eight samples, loaded once, serves several
// taps. For the 50 taps of a detection's linear prediction that is 8 times as fast as a plain loop that the compiler
// vectorises (tests/bench/kernels_bench.cpp), and within a tenth of what the processor can multiply and add.

namespace bouncelab::audio {
namespace {

constexpr std::size_t kStride = 8;
constexpr std::size_t kOutputs = 16;  // at once

/// Where there are no such registers. @param n_at_once  outputs side by side
template <std::size_t n_at_once>
void correlate_plainly(const float* x, const float* taps, std::size_t n_taps, float* out) {
  std::array<float, n_at_once> sum{};
  for (std::size_t first = 0; first < std::min(kStride, n_taps); ++first)
    for (std::size_t k = first; k < n_taps; k += kStride)
      for (std::size_t c = 0; c < n_at_once; ++c) sum[c] = std::fma(taps[k], x[k + c], sum[c]);
  std::copy(sum.begin(), sum.end(), out);
}

#ifdef __wasm_simd128__
/// As many outputs as there are registers, two in each. WebAssembly has no fused multiply-add. In doubles the product
/// of two floats is exact, and the sum, rounded to double and then to float, is the fused one unless a double that is
/// rounded itself lies halfway between two floats; then all outputs are computed again one by one. Sums that are exact
/// lie halfway often where samples are a few steps of 16 bits.
void correlate_in_doubles(const float* x, const float* taps, std::size_t n_taps, float* out) {
  using Doubles = double __attribute__((vector_size(16)));
  using Floats = float __attribute__((vector_size(8)));
  using Bits = long long __attribute__((vector_size(16)));
  constexpr std::size_t kPairs = kOutputs / 2;
  std::array<Doubles, kPairs> sum{};
  Bits is_unsure{};
  for (std::size_t first = 0; first < std::min(kStride, n_taps); ++first)
    for (std::size_t k = first; k < n_taps; k += kStride) {
      const auto tap = static_cast<double>(taps[k]);
      for (std::size_t c = 0; c < kPairs; ++c) {
        Floats samples;
        std::memcpy(&samples, x + k + 2 * c, sizeof samples);
        const Doubles product = tap * __builtin_convertvector(samples, Doubles);
        const Doubles total = sum[c] + product;
        // exact where taking off either gives the other
        const Bits is_rounded = (total - sum[c] != product) | (total - product != sum[c]);
        // the 29 bits that a float does not have are 1000...
        is_unsure |= is_rounded & ((reinterpret_cast<Bits>(total) & 0x1fffffff) == 0x10000000);
        sum[c] = __builtin_convertvector(__builtin_convertvector(total, Floats), Doubles);
      }
    }
  if ((is_unsure[0] | is_unsure[1]) != 0) return correlate_plainly<kOutputs>(x, taps, n_taps, out);
  for (std::size_t c = 0; c < kPairs; ++c) {
    const Floats rounded = __builtin_convertvector(sum[c], Floats);
    std::memcpy(out + 2 * c, &rounded, sizeof rounded);
  }
}
#endif

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

constexpr std::size_t kMostInRegisters = 56;  // outputs

/// Few outputs, as of an autocorrelation: all are held in registers, and each tap is loaded once.
template <std::size_t n_registers>
[[gnu::target("avx2,fma")]] void correlate_held(const float* x, const float* taps, std::size_t n_taps, float* out) {
  __m256 sum[n_registers];
#pragma GCC unroll 8
  for (std::size_t j = 0; j < n_registers; ++j) sum[j] = _mm256_setzero_ps();
  for (std::size_t first = 0; first < std::min(kStride, n_taps); ++first)
    for (std::size_t k = first; k < n_taps; k += kStride) {
      const __m256 tap = _mm256_set1_ps(taps[k]);
#pragma GCC unroll 8
      for (std::size_t j = 0; j < n_registers; ++j)
        sum[j] = _mm256_fmadd_ps(tap, _mm256_loadu_ps(x + k + j * kStride), sum[j]);
    }
#pragma GCC unroll 8
  for (std::size_t j = 0; j < n_registers; ++j) _mm256_storeu_ps(out + j * kStride, sum[j]);
}

using CorrelateHeld = void (*)(const float*, const float*, std::size_t, float*);
template <std::size_t... n_less_one>
constexpr std::array<CorrelateHeld, sizeof...(n_less_one)> correlate_held_of(std::index_sequence<n_less_one...>) {
  return {correlate_held<n_less_one + 1>...};
}

/// n outputs, a multiple of kStride and no more than kMostInRegisters.
void correlate_in_registers(const float* x, const float* taps, std::size_t n_taps, float* out, std::size_t n) {
  static constexpr auto kHeld = correlate_held_of(std::make_index_sequence<kMostInRegisters / kStride>());
  kHeld[n / kStride - 1](x, taps, n_taps, out);
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
constexpr std::size_t kMostInRegisters = 0;
void correlate_in_registers(const float*, const float*, std::size_t, float*, std::size_t) {}
void correlate_by_256_bits(const float*, const float*, std::size_t, float*, std::size_t) {}
constexpr bool kHas256 = false;
#endif

/// n outputs, a multiple of kOutputs.
void correlate_whole(const float* x, const float* taps, std::size_t n_taps, float* out, std::size_t n) {
  if (kHas256 && n_taps > 0) return correlate_by_256_bits(x, taps, n_taps, out, n);
#ifdef __wasm_simd128__
  constexpr auto kKernel = correlate_in_doubles;
#else
  constexpr auto kKernel = correlate_plainly<kOutputs>;
#endif
  for (std::size_t at = 0; at < n; at += kOutputs) kKernel(x + at, taps, n_taps, out + at);
}

}  // namespace

void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out) {
  assert(x.size() + 1 >= out.size() + taps.size());
  const std::size_t n = out.size(), n_whole = n - n % kOutputs;
  if (kHas256 && n > 0 && n <= kMostInRegisters && n % kStride == 0)
    return correlate_in_registers(x.data(), taps.data(), taps.size(), out.data(), n);
  correlate_whole(x.data(), taps.data(), taps.size(), out.data(), n_whole);
  if (n_whole == n) return;
  if (n >= kOutputs) {  // of the last ones some are computed twice, which takes less time than one by one
    const std::size_t last = n - kOutputs;
    return correlate_whole(x.data() + last, taps.data(), taps.size(), out.data() + last, kOutputs);
  }
  for (std::size_t k = 0; k < n; ++k) correlate_plainly<1>(x.data() + k, taps.data(), taps.size(), out.data() + k);
}

}  // namespace bouncelab::audio
