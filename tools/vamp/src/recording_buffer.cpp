// SPDX-License-Identifier: GPL-3.0-or-later
#include "recording_buffer.hpp"

namespace bouncelab::vamp {

void RecordingBuffer::add(const float* block) {
  samples_.resize(next_);  // the next block has again what the last one had beyond its step
  samples_.insert(samples_.end(), block, block + block_);
  next_ += step_;
}

void RecordingBuffer::clear() {
  samples_.clear();
  next_ = 0;
}

std::span<const float> RecordingBuffer::samples() const {
  std::size_t n = samples_.size();
  for (std::size_t n_zeros = 0; n > 0 && samples_[n - 1] == 0.0F && n_zeros + 1 < block_ + step_; ++n_zeros) --n;
  return std::span(samples_).first(n);
}

}  // namespace bouncelab::vamp
