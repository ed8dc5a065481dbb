// SPDX-License-Identifier: GPL-3.0-or-later
/// What the report draws of recordings and samples, as JSON text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::cli {

/// wave.json: the envelope of a recording, the impacts found, excerpts around some.
std::string wave_json(const detection::WavePreview& preview);

/// One drop in detail: its sound and marks, and its intervals measured and as the fitted law predicts them.
struct DropDetails {
  detection::WavePreview preview;
  std::vector<fit::IntervalPrediction> intervals;
};

struct RecordingDetails {
  std::string recording;
  std::int64_t n_drops = 0;  ///< in the recording; not all need be in `drops`
  std::optional<detection::LearnedWave> wave;
  std::optional<detection::NoiseSpectrum> noise;
  std::vector<DropDetails> drops;
};

/// diagnostics.json
std::string diagnostics_json(const std::vector<RecordingDetails>& recordings);

/// Speed, coefficient of restitution and its standard error of each sample.
std::string samples_json(const RestitutionSamples& samples);

}  // namespace bouncelab::cli
