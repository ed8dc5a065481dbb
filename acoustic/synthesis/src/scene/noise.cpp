// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/noise.hpp"

#include <immintrin.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::synthesis {

#if defined(__x86_64__) && defined(__GNUC__)
#define BOUNCELAB_HAS_WIDE_PHILOX
#endif

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

namespace {

/// Blocks of words that make samples in a row: the first coordinates of as many points, the second ones, then those of
/// each block's other point.
constexpr std::size_t kPairs = 16;
constexpr std::size_t kRow = 4 * kPairs;

/// Of 31 bits. Below it a radius is drawn with 53 bits more: beyond 5.77 of its standard deviation.
constexpr std::uint32_t kFewBits = 1U << 7;

/// log u to 1 unit in the last place, u > 0 and normal: Cephes' logf (S. L. Moshier), without branches.
[[gnu::always_inline]] inline float log_of(float u) {
  constexpr std::uint32_t kSqrtHalf = 0x3f3504f3U, kMantissa = 0x007fffffU;
  const std::uint32_t above = std::bit_cast<std::uint32_t>(u) - kSqrtHalf;
  const auto exponent = static_cast<float>(static_cast<std::int32_t>(above) >> 23);
  const float x = std::bit_cast<float>((above & kMantissa) + kSqrtHalf) - 1.0F, z = x * x;
  float p = 7.0376836292e-2F;
  p = p * x - 1.1514610310e-1F;
  p = p * x + 1.1676998740e-1F;
  p = p * x - 1.2420140846e-1F;
  p = p * x + 1.4249322787e-1F;
  p = p * x - 1.6668057665e-1F;
  p = p * x + 2.0000714765e-1F;
  p = p * x - 2.4999993993e-1F;
  p = p * x + 3.3333331174e-1F;
  const float small = (x * z * p + exponent * -2.12194440e-4F) - 0.5F * z;
  return (x + small) + exponent * 0.693359375F;
}

/// sqrt(-2 log u), u from the upper 31 bits.
[[gnu::always_inline]] inline float radius_of(std::uint32_t word) {
  const float u = (static_cast<float>(static_cast<std::int32_t>(word >> 1)) + 0.5F) * 0x1p-31F;
  return std::sqrt(-2.0F * log_of(u));
}

/// A point at this radius, in a direction from 32 bits: 30 for an angle in [-pi/4, pi/4), of which sine and cosine are
/// Cephes' polynomials; one exchanges them; one turns the point by half a circle.
[[gnu::always_inline]] inline void point_of(float radius, std::uint32_t word, float& x, float& y) {
  constexpr std::uint32_t kSign = 0x80000000U, kExchange = 0x40000000U;
  constexpr auto kQuarterPi = static_cast<float>(0.25 * std::numbers::pi * 0x1p-31);
  const float a = static_cast<float>(static_cast<std::int32_t>(word << 2)) * kQuarterPi, z = a * a;
  const float sine = a + a * z * ((-1.9515295891e-4F * z + 8.3321608736e-3F) * z - 1.6666654611e-1F);
  const float cosine =
      (1.0F - 0.5F * z) + z * z * ((2.443315711809948e-5F * z - 1.388731625493765e-3F) * z + 4.166664568298827e-2F);
  const bool is_exchanged = (word & kExchange) != 0;
  const float signed_radius = std::bit_cast<float>(std::bit_cast<std::uint32_t>(radius) ^ (word & kSign));
  x = signed_radius * (is_exchanged ? sine : cosine);
  y = signed_radius * (is_exchanged ? cosine : sine);
}

/// Box and Muller's transform of blocks of four words: two points, whose coordinates are samples kPairs apart.
BOUNCELAB_VECTOR_CLONES void transform(const NoiseWords& words, float* samples) {
  for (std::size_t first = 0; first < NoiseWords::kBlocks; first += kPairs)
    for (std::size_t half = 0; half < 2; ++half) {
      const std::uint32_t *of_radius = words.word[2 * half] + first, *of_angle = words.word[2 * half + 1] + first;
      float* x = samples + 4 * first + 2 * half * kPairs;
      for (std::size_t k = 0; k < kPairs; ++k) point_of(radius_of(of_radius[k]), of_angle[k], x[k], x[kPairs + k]);
    }
}

/// Whether a word asks for a radius of more bits.
BOUNCELAB_VECTOR_CLONES bool has_few_bits(const NoiseWords& words) {
  std::uint32_t n_few = 0;
  for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k)
    n_few += ((words.word[0][k] >> 1) < kFewBits ? 1 : 0) + ((words.word[2][k] >> 1) < kFewBits ? 1 : 0);
  return n_few != 0;
}

BOUNCELAB_VECTOR_CLONES void add_scaled(const float* x, double factor, std::size_t n, double* out) {
  for (std::size_t k = 0; k < n; ++k) out[k] += factor * static_cast<double>(x[k]);
}
BOUNCELAB_VECTOR_CLONES void add_scaled(const float* x, double factor, std::size_t n, float* out) {
  const auto single = static_cast<float>(factor);
  for (std::size_t k = 0; k < n; ++k) out[k] += single * x[k];
}

}  // namespace

void WhiteNoise::far_points(std::int64_t first_frame, const NoiseWords& words, float* samples) const {
  for (std::size_t half = 0; half < 2; ++half)
    for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
      const std::uint32_t few = words.word[2 * half][k] >> 1;
      if (few >= kFewBits) continue;
      const std::size_t at = k / kPairs * kRow + 2 * half * kPairs + k % kPairs;
      const auto frame = static_cast<std::uint64_t>(first_frame) + at;
      Random random(seed_, RandomStream::noise, ((frame + 1) << 8) | source_);
      const double u = (few + random.uniform()) * 0x1p-31;
      point_of(static_cast<float>(std::sqrt(-2.0 * log(u))), words.word[2 * half + 1][k], samples[at],
               samples[at + kPairs]);
    }
}

template <class T>
void WhiteNoise::add_to(std::int64_t first_frame, double rms, std::span<T> out) const {
  constexpr auto kInRow = static_cast<std::int64_t>(kRow), kAtOnce = static_cast<std::int64_t>(NoiseWords::kFrames);
  std::int64_t frame = (first_frame >= 0 ? first_frame : first_frame - (kInRow - 1)) / kInRow * kInRow;
  auto skipped = static_cast<std::size_t>(first_frame - frame);
  NoiseWords words;
  std::array<float, NoiseWords::kFrames> samples;
  for (std::size_t k = 0; k < out.size(); frame += kAtOnce, skipped = 0) {
    words.draw(seed_, static_cast<std::uint32_t>(source_), static_cast<std::uint64_t>(frame / kInRow) * kPairs);
    transform(words, samples.data());
    if (has_few_bits(words)) far_points(frame, words, samples.data());
    const std::size_t n = std::min(samples.size() - skipped, out.size() - k);
    add_scaled(samples.data() + skipped, rms, n, out.data() + k);
    k += n;
  }
}

void WhiteNoise::add(std::int64_t first_frame, double rms, std::span<double> out) const {
  add_to(first_frame, rms, out);
}
void WhiteNoise::add(std::int64_t first_frame, double rms, std::span<float> out) const {
  add_to(first_frame, rms, out);
}

FlickerFilter::FlickerFilter(double corner_hz, double rate_hz) {
  // a pole and then a zero half a ratio above it: -20 dB a decade half of the time, -10 dB on average
  constexpr double kLowest_hz = 5.0, kRatio = 4.0;
  const auto discrete = [rate_hz](double frequency_hz) {
    return exp(-2.0 * std::numbers::pi * frequency_hz / rate_hz);
  };
  for (double f = kLowest_hz; f < corner_hz; f *= kRatio) {
    poles_.push_back(discrete(f));
    zeros_.push_back(discrete(f * std::sqrt(kRatio)));
    scale_ *= (1.0 + poles_.back()) / (1.0 + zeros_.back());
  }
  if (poles_.empty()) return;
  memory_frames_ = static_cast<std::int64_t>(log(1e6) * rate_hz / (2.0 * std::numbers::pi * kLowest_hz));
  std::vector<double> response(static_cast<std::size_t>(memory_frames_), 0.0);
  response.front() = 1.0;
  apply(response);
  double energy = 0.0;
  for (const double h : response) energy += h * h;
  rms_ = std::sqrt(energy);
}

void FlickerFilter::cascade(const std::vector<double>& poles, const std::vector<double>& zeros, double scale,
                            std::span<double> samples) {
  for (std::size_t k = 0; k < poles.size(); ++k) {
    double x_before = 0.0, y = 0.0;
    for (double& sample : samples) {
      y = poles[k] * y + sample - zeros[k] * x_before;
      x_before = sample;
      sample = y;
    }
  }
  for (double& sample : samples) sample *= scale;
}

void FlickerFilter::apply(std::span<double> samples) const { cascade(poles_, zeros_, scale_, samples); }

void FlickerFilter::whiten(std::span<double> samples) const { cascade(zeros_, poles_, 1.0 / scale_, samples); }

std::complex<double> FlickerFilter::whitening_gain(std::complex<double> z) const {
  std::complex<double> gain = 1.0 / scale_;
  for (std::size_t k = 0; k < poles_.size(); ++k) gain *= (z - poles_[k]) / (z - zeros_[k]);
  return gain;
}

}  // namespace bouncelab::synthesis
