// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::loop {

/// BALL.0017.flac
inline std::string recording_name(const std::string& ball, std::int64_t drop) {
  return synthesis::path_of_drop(ball + ".flac", drop).string();
}

}  // namespace bouncelab::loop
