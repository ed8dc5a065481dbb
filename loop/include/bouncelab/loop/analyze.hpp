// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/loop/closed_loop.hpp"

namespace bouncelab::loop {

/// Recordings of a ball -> impact times -> coefficients of restitution -> law. Nothing has to be set.
struct AnalyzeConfig {
  detection::DetectionConfig detection;
  fit::RestitutionConfig restitution;
  fit::FitConfig fit;
  bool with_details = false;  ///< fill Analysis::details
  int n_threads = 0;          ///< of detection; 0: all cores. The result does not depend on it
};

/// That of the detection, with the gravity and the height that the restitution has.
detection::DetectionConfig detection_config(const AnalyzeConfig& config);

/// One drop: its sound and marks, and its intervals measured and as the fitted law predicts them.
struct DropDetails {
  detection::WavePreview preview;
  std::vector<fit::IntervalPrediction> intervals;
};
Description members_of(const DropDetails*);

struct RecordingDetails {
  std::string recording;
  std::int64_t n_drops = 0;  ///< in the recording; not all need be in `drops`
  std::vector<DropDetails> drops;
  std::optional<detection::LearnedWave> wave;
  std::optional<detection::NoiseSpectrum> noise;
};
Description members_of(const RecordingDetails*);

/// Drops that `details` show.
constexpr std::int64_t kMostShown = 30;

struct Analysis {
  std::vector<detection::RecordingDetection> recordings;  ///< as they were given; wave and noise with details alone
  Onsets onsets;                                          ///< of all recordings, or those that were given
  fit::Restitution restitution;
  fit::FitResult fit;
  std::optional<detection::WavePreview> wave;  ///< of the first recording in which impacts were found
  std::vector<RecordingDetails> details;       ///< of the first kMostShown drops
};

/// summary.json: counts and recordings.
Description members_of(const Analysis*);

/// Impacts of recordings, each with its name. @param with_details  also wave and noise, which reports show
/// @throws as detection::detect_each
std::vector<detection::RecordingDetection> detect_all(const std::vector<std::filesystem::path>& files,
                                                      const detection::DetectionConfig& config, int n_threads,
                                                      bool with_details = false, const ProgressCallback& progress = {});

/// The whole chain, with all data in memory: a hundred bytes or so an impact.
/// @param recordings  each once
/// @throws FileError where the only recording cannot be read, InvalidArgument naming the setting that is out of range,
///         what `progress` throws
/// @return without samples where no impact was found
Analysis analyze(const std::vector<std::filesystem::path>& recordings, const AnalyzeConfig& config,
                 const StageProgress& progress = no_progress);

/// What follows detection: of impact times alone, from another program for instance.
Analysis analyze_times(Onsets onsets, const AnalyzeConfig& config, const StageProgress& progress = no_progress);
/// Of coefficients of restitution that others measured.
Analysis analyze_samples(RestitutionSamples samples, const AnalyzeConfig& config,
                         const StageProgress& progress = no_progress);
/// Sound of the channel of a recording in which impacts were found.
using SoundOf = std::function<audio::AudioSource(const detection::RecordingDetection&)>;
/// What follows detection: of recordings whose impacts are known, by hand for instance, or whose sound is in memory.
Analysis analyze_found(std::vector<detection::RecordingDetection> recordings, const AnalyzeConfig& config,
                       const SoundOf& sound_of, const StageProgress& progress = no_progress);

}  // namespace bouncelab::loop
