// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/acoustic/synthesis.hpp"

namespace bouncelab {

/// Something that strikes the ground: the ball or a second object.
struct Strike {
  double t_s = 0.0;  ///< begin of contact, from the first sample of the recording
  double x_m = 0.0, y_m = 0.0;
  double duration_s = 0.0;
  double impulse_ns = 0.0;
  std::int64_t impact_index = -1;  ///< row of the impacts; -1: not the ball
};

/// An electric click, straight into the converter; level in units of the weakest wanted peak.
struct Click {
  double t_s = 0.0;
  double level = 0.0;
};

/// Fan or motor: a noise of limited duration with soft edges.
struct Burst {
  double t_s = 0.0;
  double duration_s = 0.0;
  double level = 0.0;
  double lowest_hz = 0.0, highest_hz = 0.0;
};

/// When everything happens in a recording.
struct Schedule {
  double duration_s = 0.0;
  std::vector<Strike> strikes;     ///< by time
  std::vector<Click> clicks;       ///< by time
  std::vector<Burst> bursts;       ///< by time
  std::vector<OtherSound> others;  ///< by time
};

/// Lays the drops one after the other: lead-in, release, impacts, pause, release ...
/// @throws InvalidArgument where an impact has no forward impulse
Schedule make_schedule(const Impacts& impacts, const SynthesisConfig& config);

}  // namespace bouncelab
