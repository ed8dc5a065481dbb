// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/white_window.hpp"

#include "bouncelab/audio/dsp/linear_prediction.hpp"

namespace bouncelab::audio {

WhiteWindow read_white(const AudioSource& source, const std::vector<float>& whitener, std::int64_t first,
                       std::size_t n) {
  WhiteWindow window{first, std::vector<float>(n)};
  read_innovations(source, {whitener, 0.0}, first, window.sound);
  return window;
}

}  // namespace bouncelab::audio
