// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/kernels.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::audio {
namespace {

using Lanes = float __attribute__((vector_size(32)));  // one wide register, or two narrow ones
constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(float);
constexpr std::size_t kChains = 4;  // independent sums that hide an addition's latency
constexpr std::size_t kDotBlock = kLanes * kChains;

void dot_lanes(const float* a, const float* b, std::size_t n, float* lanes) {
  std::array<Lanes, kChains> sum{};
  for (std::size_t k = 0; k < n; k += kDotBlock)
    for (std::size_t c = 0; c < kChains; ++c) {
      Lanes x, y;
      std::memcpy(&x, a + k + c * kLanes, sizeof x);
      std::memcpy(&y, b + k + c * kLanes, sizeof y);
      sum[c] += x * y;
    }
  std::memcpy(lanes, sum.data(), sizeof sum);
}

/// Side by side, or each comparison waits for the one before.
float largest_of(const float* x, std::size_t n) {
  std::array<float, 16> lanes;
  lanes.fill(-INFINITY);
  std::size_t k = 0;
  for (; k + lanes.size() <= n; k += lanes.size())
    for (std::size_t lane = 0; lane < lanes.size(); ++lane)
      lanes[lane] = x[k + lane] > lanes[lane] ? x[k + lane] : lanes[lane];
  return std::max(*std::max_element(lanes.begin(), lanes.end()), k < n ? *std::max_element(x + k, x + n) : -INFINITY);
}

// filter_and_decimate: of four outputs at once, so that one transposition sums the lanes of all.
constexpr std::size_t kTapsAtOnce = 16;
constexpr std::size_t kDecimated = 4;
using Taps = float __attribute__((vector_size(4 * kTapsAtOnce)));
using Eight = float __attribute__((vector_size(32)));
using Four = float __attribute__((vector_size(16)));

[[gnu::always_inline]] inline Four folded(const Taps& x) {
  const Eight eight = __builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7) +
                      __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15);
  return __builtin_shufflevector(eight, eight, 0, 1, 2, 3) + __builtin_shufflevector(eight, eight, 4, 5, 6, 7);
}

/// @param n_out  1 ... kDecimated outputs; the same bits whatever the number
template <std::size_t n_out>
[[gnu::always_inline]] inline void decimate_few(const float* x, std::size_t factor, const float* taps,
                                                std::size_t n_taps, float* out) {
  std::array<Taps, kDecimated> sum{};
  for (std::size_t k = 0; k < n_taps; k += kTapsAtOnce) {
    Taps tap;
    std::memcpy(&tap, taps + k, sizeof tap);
    for (std::size_t n = 0; n < n_out; ++n) {
      Taps samples;
      std::memcpy(&samples, x + n * factor + k, sizeof samples);
      sum[n] += tap * samples;
    }
  }
  const Four a = folded(sum[0]), b = folded(sum[1]), c = folded(sum[2]), d = folded(sum[3]);
  const Four ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Four cd = __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const Four all = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  std::memcpy(out, &all, n_out * sizeof(float));
}

BOUNCELAB_VECTOR_CLONES void decimate_all(const float* x, std::size_t factor, const float* taps, std::size_t n_taps,
                                          float* out, std::size_t n_out) {
  std::size_t n = 0;
  for (; n + kDecimated <= n_out; n += kDecimated)
    decimate_few<kDecimated>(x + n * factor, factor, taps, n_taps, out + n);
  for (; n < n_out; ++n) decimate_few<1>(x + n * factor, factor, taps, n_taps, out + n);
}

}  // namespace

double dot(std::span<const float> a, std::span<const float> b) {
  const std::size_t n = std::min(a.size(), b.size());
  const std::size_t n_whole = n - n % kDotBlock;
  std::array<float, kDotBlock> lanes;
  dot_lanes(a.data(), b.data(), n_whole, lanes.data());
  std::array<double, 4> sums{};  // side by side, or each addition waits for the one before
  for (std::size_t k = 0; k < kDotBlock; k += sums.size())
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c] += lanes[k + c];
  double sum = (sums[0] + sums[2]) + (sums[1] + sums[3]);
  for (std::size_t k = n_whole; k < n; ++k) sum += static_cast<double>(a[k]) * b[k];
  return sum;
}

double dot(const double* a, const double* b, std::size_t n) {
  constexpr std::size_t kSums = 8;
  std::array<double, kSums> sums{};
  std::size_t k = 0;
  for (; k + kSums <= n; k += kSums)
    for (std::size_t lane = 0; lane < kSums; ++lane) sums[lane] += a[k + lane] * b[k + lane];
  for (; k < n; ++k) sums[0] += a[k] * b[k];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

float largest(std::span<const float> x) { return largest_of(x.data(), x.size()); }

void add_scaled(float* to, float factor, const float* x, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) to[k] += factor * x[k];
}

void add_scaled(double* __restrict to, double factor, const double* x, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) to[k] += factor * x[k];
}

BOUNCELAB_VECTOR_CLONES void add_four_scaled(double* to, const double factors[4], const double* const x[4],
                                             std::size_t n) {
  const double *a = x[0], *b = x[1], *c = x[2], *d = x[3];
  for (std::size_t k = 0; k < n; ++k)
    to[k] += (factors[0] * a[k] + factors[1] * b[k]) + (factors[2] * c[k] + factors[3] * d[k]);
}

void multiply(const double* a, const double* b, double* __restrict product, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) product[k] = a[k] * b[k];
}

void filter_and_decimate(std::span<const float> x, std::size_t factor, std::span<const float> taps,
                         std::span<float> out) {
  assert(taps.size() % kTapsAtOnce == 0);
  assert(out.empty() || x.size() >= (out.size() - 1) * factor + taps.size());
  decimate_all(x.data(), factor, taps.data(), taps.size(), out.data(), out.size());
}

}  // namespace bouncelab::audio
