// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp.hpp"

#include <algorithm>
#include <array>
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

float largest(std::span<const float> x) {
  std::array<float, 16> lanes;  // side by side, or each comparison waits for the one before
  lanes.fill(-INFINITY);
  for (; x.size() >= lanes.size(); x = x.subspan(lanes.size()))
    for (std::size_t lane = 0; lane < lanes.size(); ++lane) lanes[lane] = x[lane] > lanes[lane] ? x[lane] : lanes[lane];
  for (std::size_t lane = 0; lane < x.size(); ++lane) lanes[lane] = std::max(lanes[lane], x[lane]);
  return *std::max_element(lanes.begin(), lanes.end());
}

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

}  // namespace bouncelab::audio
