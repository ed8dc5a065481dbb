// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "bouncelab/core/onsets.hpp"

namespace bouncelab::vamp {

/// "drop 0, impact 3", or "drop 0, impact 3, overlap" with a flag.
inline std::string label_of(std::int64_t drop, std::int64_t impact, const Flags& flags) {
  std::string label = "drop " + std::to_string(drop) + ", impact " + std::to_string(impact);
  if (!flags.empty()) label += ", " + flags.text();
  return label;
}

}  // namespace bouncelab::vamp
