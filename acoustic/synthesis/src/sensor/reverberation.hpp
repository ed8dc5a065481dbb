// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "bouncelab/synthesis/sensor.hpp"

namespace bouncelab::synthesis {

/// Diffuse reverberation tail of a room: a feedback delay network of eight lines, 11 to 37 ms long, mixed by an
/// orthogonal (Hadamard) matrix, each attenuated so that the whole falls by 60 dB in the time wanted. Source: Jot &
/// Chaigne, Digital delay networks for designing artificial reverberators, AES 90th Convention (1991).
class ReverberationTail {
 public:
  ReverberationTail(const Reverberation& room, double rate_hz);
  /// False if there is no tail.
  bool is_audible() const { return input_gain_ > 0.0; }
  /// After this many frames the tail has fallen by 180 dB.
  std::int64_t memory_frames() const { return memory_frames_; }
  /// Adds the tail to a sound, in place. Starts from silence.
  void add_to(std::span<double> sound) const;

 private:
  static constexpr std::size_t kLines = 8;
  std::array<std::size_t, kLines> lengths_{};
  std::array<double, kLines> losses_{};
  double input_gain_ = 0.0;
  std::int64_t memory_frames_ = 0;
};

}  // namespace bouncelab::synthesis
