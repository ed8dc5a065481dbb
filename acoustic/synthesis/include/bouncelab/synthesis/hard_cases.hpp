// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::synthesis {

/// A kind of recording in which impacts are hard to detect: one difficulty each; `rough` combines most of them.
struct HardCase {
  std::string name;
  std::string what;  ///< one line for people
};

/// noisy, hum, clicks, knocks, double-hits, robot, clipped, wander, dead-channel, ringing, microphone, rough.
const std::vector<HardCase>& hard_cases();

/// `config` with the difficulty added; everything else stays as it is.
/// @throws InvalidArgument naming the case and the known ones
SynthesisConfig with_hard_case(SynthesisConfig config, const std::string& name);

}  // namespace bouncelab::synthesis
