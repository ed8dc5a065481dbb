// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a recording is clipped at an impact.
#pragma once

#include <cmath>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"

namespace bouncelab::detection {

/// The values beyond which a converter or an amplifier gives none, full scale or less.
struct ClippingLimits {
  float lowest = -INFINITY, highest = INFINITY;  ///< infinite where the recording has no such limit

  /// Whether the recording reaches one of them within 5 ms after t_s [s].
  bool are_reached(const audio::AudioSource& sound, double t_s) const;
};

/// A limit is the largest value of a recording, or the smallest, if more than one impact reaches it, and below full
/// scale stays at it for two samples: two crests may be equal by chance, or two samples of the crest of a slow wave.
/// @param impacts_s  times of the impacts [s]
ClippingLimits find_clipping_limits(const audio::AudioSource& sound, const std::vector<double>& impacts_s);

}  // namespace bouncelab::detection
