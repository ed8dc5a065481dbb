// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "bouncelab/audio/audio_writer.hpp"

namespace bouncelab::test {

/// A sound of FLAC at 48 kHz whose blocks have about equal sizes.
inline void write_flac(const std::filesystem::path& path, audio::SampleEncoding encoding, int n_channels,
                       std::int64_t n_frames) {
  audio::AudioWriter writer(path, {48000, n_channels, encoding}, n_frames, true);
  std::vector<float> x(static_cast<std::size_t>(n_frames * n_channels));
  for (std::size_t k = 0; k < x.size(); ++k)
    x[k] = 0.4F * static_cast<float>(std::sin(1e-3 * static_cast<double>(k * k % 100'003)));
  writer.write(std::span<const float>(x));
  writer.commit();
}

}  // namespace bouncelab::test
