// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/onsets.hpp"

namespace bouncelab::detection {

/// The sound around one impact, with all marks within.
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
Description members_of(const WaveExcerpt::Mark*);
Description members_of(const WaveExcerpt*);

/// A piece of the recording for the ear: one channel, 16 bit, its peak at 0.9 of full scale.
struct ListeningCopy {
  double t0_s = 0.0;  ///< of its first sample in the recording
  double rate_hz = 0.0;
  std::vector<std::int16_t> samples;
};
Description members_of(const ListeningCopy*);

/// The sound from half a second before the first mark to half a second after the last, at most 30 s of it; decimated
/// to at most 24 kHz: for listening, not for measuring. Empty where there is no mark or no sound.
ListeningCopy listening_copy(const audio::AudioSource& sound, const Onsets& marks);

/// A recording reduced for a plot: extremes in at most 2,000 columns, and a few impacts at full resolution.
struct WavePreview {
  std::string recording;
  double rate_hz = 0.0;
  int channel = 0;
  double duration_s = 0.0;
  std::vector<double> column_t_s;  ///< centre of each column
  std::vector<double> lo;          ///< least sample of the column
  std::vector<double> hi;          ///< greatest
  Onsets marks;
  ListeningCopy copy;                 ///< of the whole recording's preview; empty of a drop's
  std::vector<WaveExcerpt> excerpts;  ///< an early, two middle, a late impact: 3 ms before to 8 ms after
};
Description members_of(const WavePreview*);

/// @param onsets  of this recording (those of other recordings are ignored, by their name)
WavePreview wave_preview(const audio::AudioSource& sound, const std::string& recording, int channel,
                         const Onsets& onsets);
/// One drop of it, with margins of a tenth of its duration (10 ms to 0.5 s) before its first and after its last impact,
/// and excerpts of that drop. @throws InvalidArgument where there is no such drop
WavePreview drop_preview(const audio::AudioSource& sound, const std::string& recording, int channel,
                         const Onsets& onsets, std::int64_t drop);
/// @param rate_hz  of numbers without a sampling rate. @param track  of several, from 0
/// @throws FileError where the recording cannot be read
WavePreview wave_preview(const std::filesystem::path& recording, int channel, const Onsets& onsets,
                         std::optional<double> rate_hz = std::nullopt, int track = 0);

}  // namespace bouncelab::detection
