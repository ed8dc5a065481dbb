// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "autoregression.hpp"
#include "bouncelab/acoustic/detection.hpp"
#include "bouncelab/acoustic/sound.hpp"
#include "candidates.hpp"
#include "trains.hpp"

namespace bouncelab {

/// What the timing needs to know of a recording. Refers to what it is made from.
struct HeardRecording {
  const Sound& band;   ///< the sound in the band in which the trains were heard
  const Sound& whole;  ///< the whole band
  const Autoregression& noise;
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
TimedRecording time_recording(const HeardRecording& heard, const std::string& name);

}  // namespace bouncelab
