// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/noise_words.hpp"

#include "bouncelab/core/random.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define BOUNCELAB_HAS_WIDE_PHILOX
#endif

namespace bouncelab::synthesis {
namespace {

constexpr std::uint32_t kMultiplier[2] = {0xD2511F53U, 0xCD9E8D57U};
constexpr std::uint32_t kKeyStep[2] = {0x9E3779B9U, 0xBB67AE85U};
constexpr int kRounds = 10;
constexpr auto kStream = static_cast<std::uint32_t>(RandomStream::noise);

struct Key {
  std::uint32_t lower, upper;

  explicit Key(std::uint64_t seed)
      : lower(static_cast<std::uint32_t>(seed)), upper(static_cast<std::uint32_t>(seed >> 32)) {}
  void step() {
    lower += kKeyStep[0];
    upper += kKeyStep[1];
  }
};

/// Where there are no wide registers.
void draw_plainly(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block, NoiseWords& words) {
  for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
    const std::uint64_t block = first_block + k;
    std::uint32_t a = static_cast<std::uint32_t>(block), b = static_cast<std::uint32_t>(block >> 32), c = source,
                  d = kStream;
    Key key(seed);
    for (int round = 0; round < kRounds; ++round, key.step()) {
      const std::uint64_t p = std::uint64_t{a} * kMultiplier[0], q = std::uint64_t{c} * kMultiplier[1];
      a = static_cast<std::uint32_t>(q >> 32) ^ b ^ key.lower;
      b = static_cast<std::uint32_t>(q);
      c = static_cast<std::uint32_t>(p >> 32) ^ d ^ key.upper;
      d = static_cast<std::uint32_t>(p);
    }
    words.word[0][k] = a;
    words.word[1][k] = b;
    words.word[2][k] = c;
    words.word[3][k] = d;
  }
}

#ifdef BOUNCELAB_HAS_WIDE_PHILOX
// A word is the lower half of a lane of 64 bits, of which a multiplication reads no more; what is above it does no
// harm. The lanes of even blocks are in one register, those of odd blocks in another, so that two make 32-bit words in
// order.

/// 32 blocks, in four registers for each word: a round of one is computed while that of the others is on its way.
[[gnu::target("avx512f"), gnu::always_inline]] inline void draw_32_blocks(std::uint64_t seed, std::uint32_t source,
                                                                          std::uint64_t first_block,
                                                                          std::uint32_t* const out[4]) {
  constexpr __mmask8 kAll = 0xFF;  // gcc 12 warns of the unmasked ones: their headers read what is not initialized
  constexpr std::size_t kRegisters = 4;  // even and odd blocks of 16, then of the next 16
  const __m512i p_factor = _mm512_set1_epi64(kMultiplier[0]), q_factor = _mm512_set1_epi64(kMultiplier[1]);
  const __m512i even = _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14);
  __m512i a[kRegisters], b[kRegisters], c[kRegisters], d[kRegisters];
  for (std::size_t i = 0; i < kRegisters; ++i) {
    const std::uint64_t begin = first_block + i / 2 * 16 + i % 2;
    a[i] = _mm512_add_epi64(_mm512_set1_epi64(static_cast<long long>(begin)), even);
    b[i] = _mm512_maskz_srli_epi64(kAll, a[i], 32);
    c[i] = _mm512_set1_epi64(source);
    d[i] = _mm512_set1_epi64(kStream);
  }
  Key key(seed);
  for (int round = 0; round < kRounds; ++round, key.step()) {
    const __m512i lower = _mm512_set1_epi64(key.lower), upper = _mm512_set1_epi64(key.upper);
    for (std::size_t i = 0; i < kRegisters; ++i) {
      constexpr int kXorOfThree = 0x96;
      const __m512i p = _mm512_maskz_mul_epu32(kAll, a[i], p_factor), q = _mm512_maskz_mul_epu32(kAll, c[i], q_factor);
      a[i] = _mm512_ternarylogic_epi64(_mm512_maskz_srli_epi64(kAll, q, 32), b[i], lower, kXorOfThree);
      b[i] = q;
      c[i] = _mm512_ternarylogic_epi64(_mm512_maskz_srli_epi64(kAll, p, 32), d[i], upper, kXorOfThree);
      d[i] = p;
    }
  }
  const __m512i* const lanes[4] = {a, b, c, d};
  for (int w = 0; w < 4; ++w)
    for (std::size_t i = 0; i < kRegisters; i += 2)
      _mm512_storeu_si512(out[w] + i * 8, _mm512_mask_blend_epi32(0xAAAA, lanes[w][i],
                                                                  _mm512_maskz_slli_epi64(kAll, lanes[w][i + 1], 32)));
}

[[gnu::target("avx512f")]] void draw_by_512_bits(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block,
                                                 NoiseWords& words) {
  for (std::size_t first = 0; first < NoiseWords::kBlocks; first += 32) {
    std::uint32_t* const out[4] = {words.word[0] + first, words.word[1] + first, words.word[2] + first,
                                   words.word[3] + first};
    draw_32_blocks(seed, source, first_block + first, out);
  }
}

[[gnu::target("avx2")]] void draw_by_256_bits(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block,
                                              NoiseWords& words) {
  const __m256i p_factor = _mm256_set1_epi64x(kMultiplier[0]), q_factor = _mm256_set1_epi64x(kMultiplier[1]);
  const __m256i even = _mm256_setr_epi64x(0, 2, 4, 6);
  for (std::size_t first = 0; first < NoiseWords::kBlocks; first += 8) {
    __m256i a[2], b[2], c[2], d[2];
    for (int odd = 0; odd < 2; ++odd) {
      a[odd] = _mm256_add_epi64(_mm256_set1_epi64x(static_cast<long long>(first_block + first) + odd), even);
      b[odd] = _mm256_srli_epi64(a[odd], 32);
      c[odd] = _mm256_set1_epi64x(source);
      d[odd] = _mm256_set1_epi64x(kStream);
    }
    Key key(seed);
    for (int round = 0; round < kRounds; ++round, key.step()) {
      const __m256i lower = _mm256_set1_epi64x(key.lower), upper = _mm256_set1_epi64x(key.upper);
      for (int odd = 0; odd < 2; ++odd) {
        const __m256i p = _mm256_mul_epu32(a[odd], p_factor), q = _mm256_mul_epu32(c[odd], q_factor);
        a[odd] = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(q, 32), b[odd]), lower);
        b[odd] = q;
        c[odd] = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p, 32), d[odd]), upper);
        d[odd] = p;
      }
    }
    const __m256i* const lanes[4] = {a, b, c, d};
    for (int w = 0; w < 4; ++w)
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(words.word[w] + first),
                          _mm256_blend_epi32(lanes[w][0], _mm256_slli_epi64(lanes[w][1], 32), 0xAA));
  }
}

using Draw = void (*)(std::uint64_t, std::uint32_t, std::uint64_t, NoiseWords&);
const Draw kDraw = __builtin_cpu_supports("avx512f") ? draw_by_512_bits
                   : __builtin_cpu_supports("avx2")  ? draw_by_256_bits
                                                     : draw_plainly;
#else
constexpr auto kDraw = draw_plainly;
#endif

}  // namespace

void NoiseWords::draw(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block) {
  kDraw(seed, source, first_block, *this);
}

}  // namespace bouncelab::synthesis
