// SPDX-License-Identifier: GPL-3.0-or-later
// Gaps between the time stamps of a container's blocks.
#pragma once

#include <vector>

#include "io/sound_header.hpp"

namespace bouncelab::audio {

/// A packet of a container, or what was decoded of one.
struct StampedBlock {
  double begin_s = 0.0;
  double length_s = 0.0;
};

/// Where the time stamps run ahead of the samples, or go back.
struct StampGap {
  double after_s = 0.0;    ///< samples that come before it, in seconds
  double stamped_s = 0.0;  ///< by the time stamps; below 0: the samples that follow overlap those before

  /// A pause of more than a minute, or a clock that begins anew (files that were joined).
  bool is_jump() const;
  /// What stands for it between the samples: the gap itself; for a jump, forward or back, a minute of silence.
  double length_s() const;
};

/// A gap is a step of the stamps against the lengths before them that stays: the least of the eight stamps that follow
/// is beyond the greatest of the eight before, by more than 2 ms, so that neither the rounding of stamps (1 ms in
/// Matroska) nor their jitter (clocks of browsers) is one. Its length is a whole number of blocks where it is near one:
/// blocks are lost, not parts of them.
std::vector<StampGap> gaps_between(const std::vector<StampedBlock>& blocks);

/// Puts them into info.silences and info.warning.
void say_gaps(const std::vector<StampGap>& gaps, SoundInfo& info);

}  // namespace bouncelab::audio
