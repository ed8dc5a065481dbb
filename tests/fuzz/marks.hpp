// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "bouncelab/audio/annotations.hpp"

namespace bouncelab::fuzz {

/// Finite times.
void check_marks(const audio::Annotations& marks);

/// The marks as onsets: by time, numbered upwards within a drop, and the same after a round trip through labels.
void check_onsets(const audio::Annotations& marks);

/// What was read is written and read again: as many marks, with the same labels, and times that are off by no more than
/// the tolerance.
void check_round_trip(const audio::Annotations& marks, double tolerance_s,
                      const std::function<audio::Annotations(const audio::Annotations&)>& write_and_read);

}  // namespace bouncelab::fuzz
