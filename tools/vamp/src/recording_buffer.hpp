// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bouncelab::vamp {

/// The recording as a host hands it over, block by block: blocks of block_size samples that begin step_size samples
/// after one another, the last ones filled up with zeros.
class RecordingBuffer {
 public:
  RecordingBuffer() = default;
  /// @param step_size  1 ... block_size; where it is less, blocks overlap and what they share is kept once
  RecordingBuffer(std::size_t step_size, std::size_t block_size) : step_(step_size), block_(block_size) {}

  /// Adds the next block_size samples.
  void add(const float* block);
  void clear();

  /// The samples so far without the zeros at their end, as far as the host may have put them there: fewer than
  /// block_size + step_size. They are no part of the recording's noise.
  std::span<const float> samples() const;

 private:
  std::size_t step_ = 1, block_ = 1, next_ = 0;
  std::vector<float> samples_;
};

}  // namespace bouncelab::vamp
