// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/reverberation.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::synthesis {
namespace {

/// Mutually prime at 48 kHz, so that echoes do not coincide.
constexpr std::array<double, 8> kLengths_s{11.10e-3, 13.52e-3, 16.23e-3, 19.31e-3,
                                           22.77e-3, 26.69e-3, 31.40e-3, 36.77e-3};

/// Orthogonal mixing: Hadamard's matrix over sqrt 8, in three rounds of sums and differences.
void mix(std::array<double, 8>& x) {
  for (std::size_t half = 1; half < 8; half *= 2)
    for (std::size_t start = 0; start < 8; start += 2 * half)
      for (std::size_t k = start; k < start + half; ++k) {
        const double sum = x[k] + x[k + half], difference = x[k] - x[k + half];
        x[k] = sum;
        x[k + half] = difference;
      }
  for (double& value : x) value *= 0.35355339059327373;
}

}  // namespace

ReverberationTail::ReverberationTail(const Reverberation& room, double rate_hz) {
  if (room.level_db <= -200.0) return;
  for (std::size_t k = 0; k < kLines; ++k) {
    lengths_[k] = static_cast<std::size_t>(std::lround(kLengths_s[k] * rate_hz));
    losses_[k] = pow(10.0, -3.0 * kLengths_s[k] / room.decay_60db_s);
  }
  memory_frames_ = static_cast<std::int64_t>(3.0 * room.decay_60db_s * rate_hz);
  // the level by trial: the tail of an impulse at gain 1
  input_gain_ = 1.0;
  std::vector<double> response(static_cast<std::size_t>(memory_frames_), 0.0);
  response.front() = 1.0;
  add_to(response);
  double energy = -1.0;
  for (const double h : response) energy += h * h;
  input_gain_ = std::sqrt(pow(10.0, room.level_db / 10.0) / energy);
}

void ReverberationTail::add_to(std::span<double> sound) const {
  if (!is_audible()) return;
  std::array<std::vector<double>, kLines> lines;
  for (std::size_t k = 0; k < kLines; ++k) lines[k].assign(lengths_[k], 0.0);
  std::array<std::size_t, kLines> at{};
  std::array<double, kLines> out{};
  for (double& sample : sound) {
    double tail = 0.0;
    for (std::size_t k = 0; k < kLines; ++k) {
      out[k] = losses_[k] * lines[k][at[k]];
      tail += k % 2 == 0 ? out[k] : -out[k];
    }
    mix(out);
    const double direct = input_gain_ * sample;
    for (std::size_t k = 0; k < kLines; ++k) {
      lines[k][at[k]] = out[k] + direct;
      if (++at[k] == lengths_[k]) at[k] = 0;
    }
    sample += tail;
  }
}

}  // namespace bouncelab::synthesis
