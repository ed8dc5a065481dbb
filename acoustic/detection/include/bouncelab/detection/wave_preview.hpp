// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/core/onsets.hpp"

namespace bouncelab::detection {

/// The sound around one impact, with every mark that falls into it.
struct WaveExcerpt {
  struct Mark {
    double t_s = 0.0;
    std::optional<double> sigma_t_s;
    std::int64_t impact = 0;
  };
  std::string title;
  double t0_s = 0.0;  ///< time of the first sample, from the start of the recording
  double dt_s = 0.0;
  std::vector<double> samples;  ///< full scale = 1
  std::vector<Mark> marks;
};

/// A recording small enough to be drawn: extremes in about 2,000 columns, and a few impacts at full resolution.
struct WavePreview {
  std::string recording;
  double rate_hz = 0.0;
  int channel = 0;
  double duration_s = 0.0;
  std::vector<double> column_t_s;  ///< centre of each column
  std::vector<double> lo;          ///< least sample of the column
  std::vector<double> hi;          ///< greatest
  Onsets marks;
  std::vector<WaveExcerpt> excerpts;  ///< an early, two middle, a late impact: 3 ms before to 8 ms after
};

/// @param onsets  of this recording (others are passed over by their name)
WavePreview wave_preview(const audio::AudioSource& sound, const std::string& recording, int channel,
                         const Onsets& onsets);
/// One drop of it: the stretch from a tenth of the drop before its first impact to a tenth after its last (10 ms to 0.5
/// s each), with excerpts of that drop. @throws InvalidArgument where there is no such drop
WavePreview drop_preview(const audio::AudioSource& sound, const std::string& recording, int channel,
                         const Onsets& onsets, std::int64_t drop);
/// @throws FileError where the recording cannot be read
WavePreview wave_preview(const std::filesystem::path& recording, int channel, const Onsets& onsets);

}  // namespace bouncelab::detection
