// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"

namespace bouncelab::audio {

/// A stretch of a recording, whitened.
struct WhiteWindow {
  std::int64_t first = 0;  ///< sample of the recording at which it begins
  std::vector<float> sound;
};
WhiteWindow read_white(const AudioSource& source, const std::vector<float>& whitener, std::int64_t first,
                       std::size_t n);

}  // namespace bouncelab::audio
