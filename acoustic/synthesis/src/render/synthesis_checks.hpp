// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::synthesis {

/// Throw InvalidArgument naming the first value out of range.
void validate(const SynthesisConfig& config);
void validate(const Impacts& impacts, const SynthesisConfig& config);
/// @param duration_s  of a contact; the rate bounds how finely it can be followed
void check_contact(double duration_s, const SynthesisConfig& config);

}  // namespace bouncelab::synthesis
