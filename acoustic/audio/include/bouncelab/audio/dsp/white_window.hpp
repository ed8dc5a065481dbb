// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"

namespace bouncelab::audio {

/// A stretch of a recording, whitened.
struct WhiteWindow {
  std::int64_t first = 0;  ///< sample of the recording at which it begins
  std::vector<float> sound;
};
WhiteWindow read_white(const AudioSource& source, const std::vector<float>& whitener, std::int64_t first,
                       std::size_t n);

/// A recording whitened as by read_white(), the same bytes, of which what was read last is kept: windows that overlap
/// cost little more than one.
class WhiteSound {
 public:
  /// @param source   kept by reference
  /// @param n_kept   samples, at least; a window that is read must be no longer
  WhiteSound(const AudioSource& source, const std::vector<float>& whitener, std::size_t n_kept);
  void read(std::int64_t first, std::span<float> out);

 private:
  void make_blocks(std::int64_t first, std::int64_t last);

  const AudioSource& source_;
  ArModel model_;
  std::vector<float> kept_;            ///< blocks; each has the place of its number modulo how many are kept
  std::vector<std::int64_t> numbers_;  ///< of the blocks that are there
};

}  // namespace bouncelab::audio
