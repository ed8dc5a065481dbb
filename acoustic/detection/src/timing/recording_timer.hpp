// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "bouncelab/detection/detect.hpp"
#include "candidates/candidates.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// What the timing needs to know of a recording. Refers to what it is made from.
struct TimingInput {
  const audio::AudioSource& band;   ///< the sound in the band in which the trains were heard
  const audio::AudioSource& whole;  ///< the whole band
  const audio::ArModel& noise;
  const std::vector<Candidate>& candidates;
  const std::vector<Train>& trains;
};

struct TimedRecording {
  Onsets onsets;
  std::optional<LearnedWave> wave;  ///< of the longest train
  std::optional<double> contact_time_at_1_mps_s;
  std::optional<double> contact_time_sigma_s;
};

/// Times all trains. Each train of a dozen impacts or more has a wave of its own, since a drop strikes the plate at a
/// place of its own; shorter ones share that of the recording. The contact-time law is pooled over all: one ball.
TimedRecording time_recording(const TimingInput& heard, const std::string& name);

}  // namespace bouncelab::detection
