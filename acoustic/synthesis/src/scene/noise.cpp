// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/background.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::synthesis {
namespace {

constexpr std::uint32_t kMultiplier[2] = {0xD2511F53U, 0xCD9E8D57U};
constexpr std::uint32_t kKeyStep[2] = {0x9E3779B9U, 0xBB67AE85U};
constexpr int kRounds = 10;
constexpr auto kStream = static_cast<std::uint32_t>(RandomStream::noise);

/// Round by round for all blocks, so that no round waits for the one before.
/// @param a, b, c, d  the words of each block
BOUNCELAB_VECTOR_CLONES void draw_words(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block,
                                        std::uint32_t* __restrict a, std::uint32_t* __restrict b,
                                        std::uint32_t* __restrict c, std::uint32_t* __restrict d) {
  for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
    a[k] = static_cast<std::uint32_t>(first_block + k);
    b[k] = static_cast<std::uint32_t>((first_block + k) >> 32);
    c[k] = source;
    d[k] = kStream;
  }
  auto lower_key = static_cast<std::uint32_t>(seed), upper_key = static_cast<std::uint32_t>(seed >> 32);
  for (int round = 0; round < kRounds; ++round, lower_key += kKeyStep[0], upper_key += kKeyStep[1])
    for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
      const std::uint64_t p = std::uint64_t{a[k]} * kMultiplier[0], q = std::uint64_t{c[k]} * kMultiplier[1];
      a[k] = static_cast<std::uint32_t>(q >> 32) ^ b[k] ^ lower_key;
      b[k] = static_cast<std::uint32_t>(q);
      c[k] = static_cast<std::uint32_t>(p >> 32) ^ d[k] ^ upper_key;
      d[k] = static_cast<std::uint32_t>(p);
    }
}

/// Blocks of words that make samples in a row: the first coordinates of as many points, the second ones, then those of
/// each block's other point.
constexpr std::size_t kPairs = 16;
constexpr std::size_t kNoiseRow = 4 * kPairs;

/// Of 31 bits. Below it a radius is drawn with 53 bits more: beyond 5.77 of its standard deviation.
constexpr std::uint32_t kFewBits = 1U << 7;

/// log u to 1 unit in the last place, u > 0 and normal: Cephes' logf (S. L. Moshier), without branches.
[[gnu::always_inline]] inline float log_of(float u) {
  constexpr std::uint32_t kSqrtHalf = 0x3f3504f3U, kMantissa = 0x007fffffU;
  const std::uint32_t above = bouncelab::bit_cast<std::uint32_t>(u) - kSqrtHalf;
  const auto exponent = static_cast<float>(static_cast<std::int32_t>(above) >> 23);
  const float x = bouncelab::bit_cast<float>((above & kMantissa) + kSqrtHalf) - 1.0F, z = x * x;
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
  const float signed_radius = bouncelab::bit_cast<float>(bouncelab::bit_cast<std::uint32_t>(radius) ^ (word & kSign));
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
bool has_few_bits(const NoiseWords& words) {
  std::uint32_t n_few = 0;
  for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k)
    n_few += ((words.word[0][k] >> 1) < kFewBits ? 1 : 0) + ((words.word[2][k] >> 1) < kFewBits ? 1 : 0);
  return n_few != 0;
}

void add_scaled(const float* x, double factor, std::size_t n, double* out) {
  for (std::size_t k = 0; k < n; ++k) out[k] += factor * static_cast<double>(x[k]);
}
void add_scaled(const float* x, double factor, std::size_t n, float* out) {
  const auto single = static_cast<float>(factor);
  for (std::size_t k = 0; k < n; ++k) out[k] += single * x[k];
}

}  // namespace

void NoiseWords::draw(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block) {
  draw_words(seed, source, first_block, word[0], word[1], word[2], word[3]);
}

void WhiteNoise::far_points(std::int64_t first_frame, const NoiseWords& words, float* samples) const {
  for (std::size_t half = 0; half < 2; ++half)
    for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
      const std::uint32_t few = words.word[2 * half][k] >> 1;
      if (few >= kFewBits) continue;
      const std::size_t at = k / kPairs * kNoiseRow + 2 * half * kPairs + k % kPairs;
      const auto frame = static_cast<std::uint64_t>(first_frame) + at;
      Random random(seed_, RandomStream::noise, ((frame + 1) << 8) | source_);
      const double u = (few + random.uniform()) * 0x1p-31;
      point_of(static_cast<float>(std::sqrt(-2.0 * log(u))), words.word[2 * half + 1][k], samples[at],
               samples[at + kPairs]);
    }
}

template <class T>
void WhiteNoise::add_to(std::int64_t first_frame, double rms, std::span<T> out) const {
  constexpr auto kInRow = static_cast<std::int64_t>(kNoiseRow),
                 kAtOnce = static_cast<std::int64_t>(NoiseWords::kFrames);
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
