// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// A recording whitened as by read_innovations(), the same bytes, of which what was read last is kept: windows that
/// overlap, or are read again, cost little more than one.
class WhiteSound {
 public:
  /// Keeps 2^17 samples, the longest window that can be read.
  /// @param source  kept by reference
  explicit WhiteSound(const audio::AudioSource& source);
  const audio::AudioSource& source() const { return source_; }
  /// Another whitener than the last one leaves nothing of what was kept.
  void read(const std::vector<float>& whitener, std::int64_t first, std::span<float> out);

 private:
  /// Where in the memory a block is, in blocks; a block that has the same remainder may be there instead.
  std::int32_t& place(std::int64_t block);
  bool is_there(std::int64_t block);
  void make_blocks(std::int64_t first, std::int64_t last);

  const audio::AudioSource& source_;
  ArModel model_;
  std::unique_ptr<float[]> memory_;    ///< blocks, as they were first read; all are dropped where it is full
  std::vector<std::int64_t> numbers_;  ///< of the blocks there
  std::vector<std::int32_t> places_;   ///< of a block at its number modulo how many there are
};

}  // namespace bouncelab::detection
