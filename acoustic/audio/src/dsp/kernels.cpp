// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/kernels.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "bouncelab/audio/dsp/vector_clones.hpp"

namespace bouncelab::audio {
namespace {

using Lanes = float __attribute__((vector_size(32)));  // one wide register, or two narrow ones
constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(float);
constexpr std::size_t kChains = 4;  // independent sums that hide an addition's latency
constexpr std::size_t kAtOnce = kLanes * kChains;

BOUNCELAB_VECTOR_CLONES void dot_lanes(const float* a, const float* b, std::size_t n, float* lanes) {
  std::array<Lanes, kChains> sum{};
  for (std::size_t k = 0; k < n; k += kAtOnce)
    for (std::size_t c = 0; c < kChains; ++c) {
      Lanes x, y;
      std::memcpy(&x, a + k + c * kLanes, sizeof x);
      std::memcpy(&y, b + k + c * kLanes, sizeof y);
      sum[c] += x * y;
    }
  std::memcpy(lanes, sum.data(), sizeof sum);
}

/// @param n  a multiple of kLanes
BOUNCELAB_VECTOR_CLONES void moment_lanes(const float* x, float first, std::size_t n, float* lanes) {
  Lanes sum{};
  Lanes number = Lanes{0, 1, 2, 3, 4, 5, 6, 7} + first;
  for (std::size_t k = 0; k < n; k += kLanes) {
    Lanes here;
    std::memcpy(&here, x + k, sizeof here);
    sum += number * here;
    number += static_cast<float>(kLanes);
  }
  std::memcpy(lanes, &sum, sizeof sum);
}

BOUNCELAB_VECTOR_CLONES void sum_lanes(const float* x, std::size_t n, float* lanes) {
  Lanes sum{};
  for (std::size_t k = 0; k < n; k += kLanes) {
    Lanes here;
    std::memcpy(&here, x + k, sizeof here);
    sum += here;
  }
  std::memcpy(lanes, &sum, sizeof sum);
}

}  // namespace

double dot(std::span<const float> a, std::span<const float> b) {
  const std::size_t n = std::min(a.size(), b.size());
  const std::size_t n_whole = n - n % kAtOnce;
  std::array<float, kAtOnce> lanes;
  dot_lanes(a.data(), b.data(), n_whole, lanes.data());
  double sum = 0.0;
  for (const float x : lanes) sum += x;
  for (std::size_t k = n_whole; k < n; ++k) sum += static_cast<double>(a[k]) * b[k];
  return sum;
}

double sum(std::span<const float> x) {
  const std::size_t n_whole = x.size() - x.size() % kLanes;
  std::array<float, kLanes> lanes;
  sum_lanes(x.data(), n_whole, lanes.data());
  double total = 0.0;
  for (const float lane : lanes) total += lane;
  for (std::size_t k = n_whole; k < x.size(); ++k) total += x[k];
  return total;
}

double moment(std::span<const float> x, std::size_t first) {
  const std::size_t n_whole = x.size() - x.size() % kLanes;
  std::array<float, kLanes> lanes;
  moment_lanes(x.data(), static_cast<float>(first), n_whole, lanes.data());
  double total = 0.0;
  for (const float lane : lanes) total += lane;
  for (std::size_t k = n_whole; k < x.size(); ++k) total += static_cast<double>(first + k) * x[k];
  return total;
}

}  // namespace bouncelab::audio
